//! The same scene in worlds that differ from what is known of it: what a plan has to survive.

use std::sync::{Arc, OnceLock};

use super::options::{PhysicsOptions, engine_with};
use super::transition::Transition;
use crate::error::Result;
use crate::net::MotionModel;
use crate::run::Key;
use crate::scene::{Scene, State, Uncertainty};

/// Perturbed worlds with an engine each. World `k` has its own friction factors, its own place of the bodies for what
/// was observed, and its own noise of every later look, all of them functions of the key and `k`: whatever is compared
/// in the ensemble meets the same worlds (common random numbers).
pub struct Ensemble {
    scene: Arc<Scene>,
    uncertainty: Uncertainty,
    key: Key,
    engines: Vec<PhysicsOptions>,
    network: Option<Arc<dyn MotionModel>>,
    /// Each made when it is first asked for, but the first of every engine; none where it cannot be had.
    worlds: Vec<OnceLock<Option<Arc<dyn Transition>>>>,
}

/// Branches of a world's key.
const FRICTION: u64 = 0;
const PLACE: u64 = 1;
const LOOKS: u64 = 2;

impl Ensemble {
    /// `count` worlds of a scene. The engines take turns (a finer step in every other world, say); there is at least one.
    /// `network`: that of the engine `dipn`, where it is loaded already.
    pub fn new(
        scene: &Arc<Scene>,
        engines: &[PhysicsOptions],
        network: Option<&Arc<dyn MotionModel>>,
        uncertainty: Uncertainty,
        count: usize,
        key: Key,
    ) -> Result<Ensemble> {
        uncertainty.validate()?;
        let count = if engines.is_empty() { 0 } else { count };
        let ensemble = Ensemble {
            scene: Arc::clone(scene),
            uncertainty,
            key,
            engines: engines.to_vec(),
            network: network.cloned(),
            // Not `vec![..; n]`: valgrind takes the copy of an empty cell for a use of what it does not hold.
            worlds: std::iter::repeat_with(OnceLock::new).take(count).collect(),
        };
        // What is wrong with an engine shows in the first world that has it.
        for (k, world) in ensemble.worlds.iter().enumerate().take(engines.len()) {
            let _ = world.set(Some(ensemble.make(k)?));
        }
        Ok(ensemble)
    }

    fn make(&self, k: usize) -> Result<Arc<dyn Transition>> {
        let perturbed = self.uncertainty.scene(&self.scene, self.key.child(k as u64).child(FRICTION));
        engine_with(&self.engines[k % self.engines.len()], Arc::new(perturbed), self.network.as_ref())
    }

    /// How many worlds there are.
    pub fn len(&self) -> usize {
        self.worlds.len()
    }

    pub fn is_empty(&self) -> bool {
        self.worlds.is_empty()
    }

    /// What pushes do in world `k`; `None` where there is no such world.
    pub fn engine(&self, k: usize) -> Option<&Arc<dyn Transition>> {
        self.worlds.get(k)?.get_or_init(|| self.make(k).ok()).as_ref()
    }

    /// Where the bodies are in world `k` if they were observed so.
    pub fn truth(&self, k: usize, observed: &State) -> State {
        self.uncertainty.state(&self.scene, observed, self.key.child(k as u64).child(PLACE))
    }

    /// What is seen of a state of world `k` at its look number `look`.
    pub fn observe(&self, k: usize, truth: &State, look: u64) -> State {
        self.uncertainty.state(&self.scene, truth, self.key.child(k as u64).child(LOOKS).child(look))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::generate::{Generator, GeneratorParams};

    #[test]
    fn worlds_are_functions_of_the_key_and_differ_from_each_other() {
        let problem = Generator::new(GeneratorParams::default(), 1).unwrap().problem(0).unwrap();
        let engines = [PhysicsOptions::preset("fast")];
        let make = |seed, count| {
            Ensemble::new(&problem.scene, &engines, None, Uncertainty::default(), count, Key::new(seed)).unwrap()
        };
        let (a, more, other) = (make(1, 4), make(1, 8), make(2, 4));
        assert_eq!((a.len(), more.len()), (4, 8));
        let friction = |e: &Ensemble, k: usize| e.engine(k).unwrap().scene().clone();
        for k in 0..4 {
            assert_eq!(friction(&a, k), friction(&more, k), "more worlds change none of the first");
            assert_ne!(friction(&a, k), friction(&other, k));
            assert_eq!(a.truth(k, &problem.state), more.truth(k, &problem.state));
            assert_ne!(a.truth(k, &problem.state), a.truth((k + 1) % 4, &problem.state));
            assert_ne!(a.observe(k, &problem.state, 0), a.observe(k, &problem.state, 1), "every look is another one");
        }
        assert!(a.engine(4).is_none());
    }
}
