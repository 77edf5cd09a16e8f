//! `jostle observe`: what a camera above the table sees.

use jostle::eval::read_problem;
use jostle::files;
use jostle::geom::Pose2;
use jostle::vision::{Frame, ImageMut, Rasteriser};

use crate::args::{ImageArg, ObserveArgs};
use crate::output::Outcome;

pub fn run(args: &ObserveArgs) -> Outcome<()> {
    let problem = read_problem(&args.input, args.profile.profile())?;
    let (scene, state) = (&*problem.scene, &problem.state);
    let frame = match args.crop {
        Some(side) => Frame::around(scene, state, problem.target, args.heading, args.pixel, side)?,
        None => {
            let [min, max] = [scene.workspace().min, scene.workspace().max];
            let middle = Pose2::new((min[0] + max[0]) / 2.0, (min[1] + max[1]) / 2.0, args.heading);
            let pixels = |axis: usize| ((max[axis] - min[axis]) / args.pixel - 1e-6).ceil() as usize;
            Frame::new(middle, args.pixel, pixels(1), pixels(0))
        }
    };
    frame.validate()?;
    let mut rasteriser = Rasteriser::new();
    let greatest = if args.image == ImageArg::Heights { 65535 } else { 255 };
    let mut file = format!("P5\n{} {}\n{greatest}\n", frame.cols, frame.rows).into_bytes();
    if args.image == ImageArg::Heights {
        let mut heights = vec![0.0f32; frame.len()];
        let mut image = ImageMut::packed(&mut heights, frame.rows, frame.cols)?;
        rasteriser.heights(scene, state, &frame, &mut image)?;
        file.extend(heights.iter().flat_map(|height| ((height * 1e4).round() as u16).to_be_bytes()));
    } else {
        let mut pixels = vec![0u8; frame.len()];
        let mut image = ImageMut::packed(&mut pixels, frame.rows, frame.cols)?;
        match args.image {
            ImageArg::Target => rasteriser.mask(scene, state, problem.target, &frame, &mut image)?,
            ImageArg::Foreground => rasteriser.foreground(scene, state, &frame, &mut image)?,
            _ => rasteriser.labels(scene, state, &frame, &mut image)?,
        }
        let bright = if args.image == ImageArg::Labels { 1 } else { 255 };
        file.extend(pixels.iter().map(|pixel| pixel * bright));
    }
    Ok(files::write(&args.output, file)?)
}
