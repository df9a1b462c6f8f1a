//! Settings of the world.

use drystone::WorldConfig;
use drystone::config::ParticleForm;
use drystone::method::{
    Damping, Integration, Method, MethodOptions, Order, Overlap, Persistence, Rest, Shock,
};

use super::reader::Reader;
use crate::error::SceneError;
use crate::own::document;
use crate::own::place::Place;
use crate::own::value::Or;

/// Takes a value over if it is given.
fn put<T: Copy>(slot: &mut T, value: Option<T>) {
    if let Some(value) = value {
        *slot = value;
    }
}

impl Reader<'_> {
    pub(super) fn world(
        &mut self,
        place: &Place,
        world: &document::World,
    ) -> Result<(), SceneError> {
        let mut config = WorldConfig::default();
        put(&mut config.gravity, world.gravity.map(Into::into));
        put(&mut config.substeps, world.substeps);
        put(&mut config.length_scale, world.length_scale);
        if let Some(method) = &world.method {
            config.method = self.method(&place.key("method"), method)?;
        }
        if let Some(contact) = &world.contact {
            let c = &mut config.contact;
            put(&mut c.hertz, contact.hertz);
            put(&mut c.damping_ratio, contact.damping_ratio);
            put(&mut c.push_speed, contact.push_speed);
            put(&mut c.rest_offset, contact.rest_offset);
            put(&mut c.margin, contact.margin);
            put(&mut c.recycle_distance, contact.recycle_distance);
            put(&mut c.restitution_speed, contact.restitution_speed);
            put(&mut c.hit_speed, contact.hit_speed);
        }
        if let Some(inertia) = &world.inertia {
            put(&mut config.inertia.max_factor, inertia.max_factor);
            put(&mut config.inertia.threshold, inertia.threshold);
            put(&mut config.inertia.refine, inertia.refine);
        }
        if let Some(joint) = &world.joint {
            put(&mut config.joint.hertz, joint.hertz);
            put(&mut config.joint.damping_ratio, joint.damping_ratio);
            put(&mut config.joint.tree_ratio, joint.tree_ratio);
            put(&mut config.joint.refine, joint.refine);
        }
        if let Some(particle) = &world.particle {
            let form = particle.form.map(|form| match form {
                document::ParticleForm::Own => ParticleForm::Own,
                document::ParticleForm::Soft => ParticleForm::Soft,
                document::ParticleForm::Aim => ParticleForm::Aim,
                document::ParticleForm::Verlet => ParticleForm::Verlet,
            });
            put(&mut config.particle.form, form);
            put(&mut config.particle.sweeps, particle.sweeps);
            put(&mut config.particle.hertz, particle.hertz);
            put(&mut config.particle.damping_ratio, particle.damping_ratio);
        }
        if let Some(penalty) = &world.penalty {
            put(&mut config.penalty.hertz, penalty.hertz);
            put(&mut config.penalty.damping_ratio, penalty.damping_ratio);
        }
        if let Some(sleep) = &world.sleep {
            put(&mut config.sleep.enabled, sleep.enabled);
            put(&mut config.sleep.speed, sleep.speed);
            put(&mut config.sleep.time, sleep.time);
        }
        if let Some(breakage) = &world.breakage {
            put(&mut config.breakage.max_pieces, breakage.max_pieces);
        }
        config.validate().map_err(|e| self.refused(place, &e))?;
        self.scene.config = config;
        Ok(())
    }

    fn method(&self, place: &Place, method: &Or<document::Method>) -> Result<Method, SceneError> {
        let (name, at) = match method {
            Or::Name(name) => (name, place.clone()),
            Or::Here(method) => (&method.name, place.key("name")),
        };
        let found = Method::named(name)
            .ok_or_else(|| self.fail(&at, format!("is \"{name}\""), &Method::NAMES.join(", ")))?;
        let Or::Here(said) = method else { return Ok(found) };
        let mut options = MethodOptions::default();
        for (key, word) in said.words() {
            let Some(word) = word else { continue };
            let words = set_option(&mut options, key, word);
            if let Some(words) = words {
                let problem = format!("is \"{word}\"");
                return Err(self.fail(&place.key(key), problem, &words.join(", ")));
            }
        }
        put(&mut options.sweeps, said.sweeps);
        found.with_options(options).map_err(|e| {
            // The engine calls them `method.order`, as `--set` does.
            let field = e.field().trim_start_matches("method.");
            self.fail(&place.field(field), format!("is {}", e.value()), e.allowed())
        })
    }
}

/// Sets an option by its word; otherwise returns the words that it has.
fn set_option(
    options: &mut MethodOptions,
    key: &str,
    word: &str,
) -> Option<&'static [&'static str]> {
    fn set<T>(slot: &mut T, value: Option<T>) -> bool {
        let is_known = value.is_some();
        if let Some(value) = value {
            *slot = value;
        }
        is_known
    }
    let (is_known, words) = match key {
        "order" => (set(&mut options.order, Order::named(word)), Order::WORDS),
        "shock" => (set(&mut options.shock, Shock::named(word)), Shock::WORDS),
        "persistence" => {
            (set(&mut options.persistence, Persistence::named(word)), Persistence::WORDS)
        }
        "overlap" => (set(&mut options.overlap, Overlap::named(word)), Overlap::WORDS),
        "rest" => (set(&mut options.rest, Rest::named(word)), Rest::WORDS),
        "integration" => {
            (set(&mut options.integration, Integration::named(word)), Integration::WORDS)
        }
        _ => (set(&mut options.damping, Damping::named(word)), Damping::WORDS),
    };
    (!is_known).then_some(words)
}
