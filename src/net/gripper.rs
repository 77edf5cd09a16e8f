//! Whether a network was made for the gripper at hand.
//!
//! A file names its gripper; what counts is the measures, with a tolerance: the same hand measured twice, or written in a
//! struct without a name, is the same hand. A network is held to the part of the gripper that it depends on: `gc` and `gn` to
//! the jaw and to what scores its grasps, `dipn` and `ppn` to the tip. (A prior does no more than order what is tried: a
//! `ppn` is of use to a gripper with the same tip and another jaw.)

use super::info::ModelInfo;
use super::kind::Kind;
use crate::error::{Error, Result};
use crate::scene::Gripper;

/// Measures closer than this share of them are the same,
const SHARE: f64 = 0.01;
/// or closer than this: metres, for the published gripper ([`Gripper::scale`]),
const LENGTH: f64 = 0.0005;
/// or radians.
const ANGLE: f64 = 0.01;

/// Refuses a gripper other than the one that the network was made for, with the measures of both; `field` is what the error
/// names. A network that names none is for any, and one that was loaded with
/// [`Configuration::tolerate`](super::Configuration::tolerate) passes.
pub fn check_gripper(field: &str, info: &ModelInfo, have: &Gripper) -> Result<()> {
    let Some(made) = info.gripper().filter(|_| !info.tolerated) else { return Ok(()) };
    let jaw = matches!(info.kind, Kind::Gc | Kind::Gn);
    let known = Gripper::by_name(made);
    let (theirs, differs) = match &known {
        Ok(known) => (format!("`{made}` ({})", measures(known, jaw)), differing(known, have, jaw)),
        // All that is known of it is the name.
        Err(_) if have.name == made => return Ok(()),
        Err(_) => (format!("`{made}` (whose measures this library does not know)"), vec!["the name"]),
    };
    if differs.is_empty() {
        return Ok(());
    }
    let name = if have.name.is_empty() { "one without a name".into() } else { format!("`{}`", have.name) };
    let (network, kind) = (info.path.display(), info.kind.id());
    let reason = format!(
        "is {name} ({}), but the {kind} network {network} was made for {theirs}. What differs, \
         lengths by more than 1 % and 0.5 mm: {}. Give this network its gripper, or this gripper a network of its own, or \
         load the network with `tolerate`",
        measures(have, jaw),
        differs.join(", ")
    );
    Err(Error::argument(field, reason))
}

/// The names of the measures that are not the same.
fn differing(made: &Gripper, have: &Gripper, jaw: bool) -> Vec<&'static str> {
    let scale = made.scale();
    let lengths: Vec<(&'static str, f64, f64)> = if jaw {
        let (a, b) = (&made.grasp, &have.grasp);
        vec![
            ("opening", a.opening, b.opening),
            ("finger_width", a.finger_width, b.finger_width),
            ("finger_thickness", a.finger_thickness, b.finger_thickness),
            ("finger_clearance", a.finger_clearance, b.finger_clearance),
            ("fit", a.fit, b.fit),
            ("pad_edge", a.pad_edge, b.pad_edge),
            ("min_cover", a.min_cover, b.min_cover),
            ("lowest", a.lowest, b.lowest),
        ]
    } else {
        let (a, b) = (&made.push, &have.push);
        vec![("push.width", a.width, b.width), ("push.thickness", a.thickness, b.thickness)]
    };
    let apart = |a: f64, b: f64, least: f64| (a - b).abs() > least.max(SHARE * a.abs());
    let mut names: Vec<_> = lengths.iter().filter(|(_, a, b)| apart(*a, *b, scale * LENGTH)).map(|l| l.0).collect();
    if jaw && apart(made.grasp.max_wedge, have.grasp.max_wedge, ANGLE) {
        names.push("max_wedge");
    }
    let longer = |gripper: &Gripper| gripper.grasp.finger_length == f64::INFINITY;
    let same_length =
        longer(made) && longer(have) || !apart(made.grasp.finger_length, have.grasp.finger_length, scale * LENGTH);
    if jaw && !same_length {
        names.push("finger_length");
    }
    // A chance is another number than a judgement by shape.
    if jaw && made.keeping.is_some() != have.keeping.is_some() {
        names.push("what scores grasps");
    }
    names
}

fn measures(gripper: &Gripper, jaw: bool) -> String {
    let mm = |metres: f64| 1e3 * metres;
    if !jaw {
        return format!("tip {:.2} x {:.2} mm", mm(gripper.push.width), mm(gripper.push.thickness));
    }
    let g = &gripper.grasp;
    format!(
        "opening {:.2} mm, fingers {:.2} x {:.2} mm, clearance {:.2} mm, fit {:.2} mm, pad edge {:.2} mm, cover {:.2} mm, \
         wedge {:.1} degrees, scored by {}",
        mm(g.opening),
        mm(g.finger_width),
        mm(g.finger_thickness),
        mm(g.finger_clearance),
        mm(g.fit),
        mm(g.pad_edge),
        mm(g.min_cover),
        g.max_wedge.to_degrees(),
        if gripper.keeping.is_some() { "the chance of keeping" } else { "shape" }
    )
}

#[cfg(test)]
mod tests {
    use super::super::{LoadOptions, inspect};
    use super::*;

    /// What a network of this kind would say that it was made for.
    fn made(kind: Kind, gripper: &str) -> ModelInfo {
        let file = format!("{}/tests/data/nets/gc.onnx", env!("CARGO_MANIFEST_DIR"));
        let mut info = inspect(file.as_ref(), None, &LoadOptions::default()).unwrap();
        (info.kind, info.spec.gripper) = (kind, Some(gripper.into()));
        info
    }

    fn changed(change: impl Fn(&mut Gripper)) -> Gripper {
        let mut gripper = Gripper { name: "custom".into(), ..Gripper::robotiq_2f85() };
        change(&mut gripper);
        gripper
    }

    #[test]
    fn measures_decide_and_not_the_name_or_the_last_bits() {
        let gc = made(Kind::Gc, "robotiq_2f85");
        let verdict = |gripper: &Gripper| check_gripper("scene.gripper", &gc, gripper);
        for gripper in [
            Gripper::robotiq_2f85(),
            changed(|_| ()),
            changed(|g| g.grasp.opening += 0.0008),
            changed(|g| g.grasp.finger_thickness -= 0.0004),
            changed(|g| g.grasp.max_wedge += 0.003),
            // What it pushes with is nothing to a network that looks at grasps.
            changed(|g| g.push.width *= 2.0),
        ] {
            verdict(&gripper).unwrap();
        }
        let refused: [(&str, Gripper); 6] = [
            ("opening", changed(|g| g.grasp.opening += 0.0009)),
            ("finger_width", changed(|g| g.grasp.finger_width += 0.0006)),
            ("opening, finger_thickness", Gripper::dissertation_mask()),
            ("max_wedge", changed(|g| g.grasp.max_wedge += 0.02)),
            ("what scores grasps", Gripper::robotiq_2f85_kept()),
            // The name alone is not the gripper.
            ("fit", Gripper { name: "robotiq_2f85".into(), ..changed(|g| g.grasp.fit += 0.001) }),
        ];
        for (differs, gripper) in refused {
            let error = verdict(&gripper).unwrap_err();
            assert!(matches!(&error, Error::Argument { field, .. } if field == "scene.gripper"), "{error}");
            let text = error.to_string();
            assert!(text.contains(&format!("by more than 1 % and 0.5 mm: {differs}. Give")), "{text}");
            assert!(text.contains("was made for `robotiq_2f85` (opening 80.70 mm, fingers 22.00 x 15.00 mm"), "{text}");
            assert!(text.contains(&measures(&gripper, true)) && text.contains("gc.onnx"), "{text}");
        }
    }

    #[test]
    fn a_network_is_held_to_the_part_that_it_depends_on() {
        let thick = changed(|g| g.push.thickness = 0.03);
        for kind in [Kind::Dipn, Kind::Ppn] {
            let info = made(kind, "robotiq_2f85");
            check_gripper("gripper", &info, &Gripper::dissertation_mask()).unwrap();
            let text = check_gripper("gripper", &info, &thick).unwrap_err().to_string();
            assert!(text.starts_with("gripper: is `custom` (tip 30.00 x 30.00 mm), but the "), "{text}");
            assert!(
                text.contains("`robotiq_2f85` (tip 30.00 x 22.00 mm). What") && text.contains(": push.thickness. "),
                "{text}"
            );
        }
        let mut any = made(Kind::Dipn, "robotiq_2f85");
        any.spec.gripper = None;
        check_gripper("gripper", &any, &thick).unwrap();
        let tolerated = ModelInfo { tolerated: true, ..made(Kind::Gn, "robotiq_2f85") };
        check_gripper("gripper", &tolerated, &Gripper::dissertation_mask()).unwrap();
    }

    #[test]
    fn a_gripper_that_the_library_does_not_know_is_known_by_its_name_alone() {
        let claw = made(Kind::Gn, "claw");
        check_gripper("gripper", &claw, &Gripper { name: "claw".into(), ..Gripper::dissertation_mask() }).unwrap();
        let text = check_gripper("gripper", &claw, &Gripper::robotiq_2f85()).unwrap_err().to_string();
        assert!(text.contains("made for `claw` (whose measures this library does not know)"), "{text}");
        let nameless = Gripper { name: String::new(), ..Gripper::robotiq_2f85() };
        let text = check_gripper("gripper", &claw, &nameless).unwrap_err().to_string();
        assert!(text.starts_with("gripper: is one without a name (opening"), "{text}");
    }
}
