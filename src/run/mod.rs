//! Placeholder for the stop token until the run module lands.
pub struct Stop;
impl Stop {
    pub fn never() -> Self {
        Stop
    }
    pub fn requested(&self) -> bool {
        false
    }
}
