//! What a stand-in for a network says of pushes: what the tip meets goes along with it, without a turn, and the rest stays.

use jostle::net::ObjectBatch;

/// For bodies of about 45 mm before a tip of 30 by 22 mm: one whose centre is less than `beside` off the tip's way goes
/// along from where the centre is `ahead` of the tip's, metres.
pub fn carried_along(batch: &ObjectBatch, beside: f64, ahead: f64, motions: &mut Vec<[f32; 3]>) {
    motions.clear();
    for item in 0..batch.items() {
        let length = batch.push_length(item);
        for body in 0..batch.objects() {
            let [x, y] = batch.centre(item, body);
            let way = (length - (x - ahead)).clamp(0.0, length);
            motions.push([if y.abs() < beside && x > 0.0 { way as f32 } else { 0.0 }, 0.0, 0.0]);
        }
    }
}
