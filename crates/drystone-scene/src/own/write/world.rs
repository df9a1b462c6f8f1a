//! Settings of the world.

use drystone::WorldConfig;
use drystone::method::MethodOptions;

use super::said::{other, unless, unless_vec};
use crate::own::document::{
    Breakage, Contact, Inertia, Joints, Method, ParticleForm, Particles, Penalty, Sleep, World,
};
use crate::own::value::Or;

/// A part that says something.
fn some<T: Default + PartialEq>(part: T) -> Option<T> {
    other(part, &T::default())
}

pub(super) fn world(config: &WorldConfig) -> Option<World> {
    let default = WorldConfig::default();
    let (c, d) = (&config.contact, &default.contact);
    let contact = some(Contact {
        hertz: unless(c.hertz, d.hertz),
        damping_ratio: unless(c.damping_ratio, d.damping_ratio),
        push_speed: unless(c.push_speed, d.push_speed),
        rest_offset: unless(c.rest_offset, d.rest_offset),
        margin: unless(c.margin, d.margin),
        recycle_distance: unless(c.recycle_distance, d.recycle_distance),
        restitution_speed: unless(c.restitution_speed, d.restitution_speed),
        hit_speed: unless(c.hit_speed, d.hit_speed),
    });
    let (i, d) = (&config.inertia, &default.inertia);
    let inertia = some(Inertia {
        max_factor: unless(i.max_factor, d.max_factor),
        threshold: unless(i.threshold, d.threshold),
        refine: other(i.refine, &d.refine),
    });
    let (j, d) = (&config.joint, &default.joint);
    let joint = some(Joints {
        hertz: unless(j.hertz, d.hertz),
        damping_ratio: unless(j.damping_ratio, d.damping_ratio),
        tree_ratio: unless(j.tree_ratio, d.tree_ratio),
        refine: other(j.refine, &d.refine),
    });
    let (p, d) = (&config.particle, &default.particle);
    let form = match p.form {
        drystone::config::ParticleForm::Own => ParticleForm::Own,
        drystone::config::ParticleForm::Soft => ParticleForm::Soft,
        drystone::config::ParticleForm::Aim => ParticleForm::Aim,
        drystone::config::ParticleForm::Verlet => ParticleForm::Verlet,
    };
    let particle = some(Particles {
        form: other(form, &ParticleForm::Own),
        sweeps: other(p.sweeps, &d.sweeps),
        hertz: unless(p.hertz, d.hertz),
        damping_ratio: unless(p.damping_ratio, d.damping_ratio),
    });
    let (p, d) = (&config.penalty, &default.penalty);
    let penalty = some(Penalty {
        hertz: unless(p.hertz, d.hertz),
        damping_ratio: unless(p.damping_ratio, d.damping_ratio),
    });
    let (s, d) = (&config.sleep, &default.sleep);
    let sleep = some(Sleep {
        enabled: other(s.enabled, &d.enabled),
        speed: unless(s.speed, d.speed),
        time: unless(s.time, d.time),
    });
    let (b, d) = (&config.breakage, &default.breakage);
    let breakage = some(Breakage { max_pieces: other(b.max_pieces, &d.max_pieces) });
    let is_default = *config == default && unless_vec(config.gravity, default.gravity).is_none();
    (!is_default).then(|| World {
        gravity: unless_vec(config.gravity, default.gravity),
        method: method(config),
        length_scale: unless(config.length_scale, default.length_scale),
        substeps: other(config.substeps, &default.substeps),
        contact,
        inertia,
        joint,
        particle,
        penalty,
        sleep,
        breakage,
    })
}

fn method(config: &WorldConfig) -> Option<Or<Method>> {
    let (method, plain) = (&config.method, MethodOptions::default());
    let options = method.options();
    if *options == plain {
        let name = method.name().to_owned();
        return (name != drystone::method::Method::soft_step().name()).then_some(Or::Name(name));
    }
    let word = |word: &str| (word != "own").then(|| word.to_owned());
    Some(Or::Here(Method {
        name: method.name().to_owned(),
        order: word(options.order.word()),
        shock: word(options.shock.word()),
        persistence: word(options.persistence.word()),
        overlap: word(options.overlap.word()),
        rest: word(options.rest.word()),
        integration: word(options.integration.word()),
        damping: word(options.damping.word()),
        sweeps: other(options.sweeps, &plain.sweeps),
    }))
}
