//! Helpers of the tests against parry.

use parry3d::math::Vector;

use crate::base::math::{Vec3, vec3};

/// Random numbers from -1 to 1, by a linear congruential generator.
pub(crate) struct Numbers(pub(crate) u32);

impl Numbers {
    pub(crate) fn next(&mut self) -> f32 {
        self.0 = self.0.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (self.0 >> 8) as f32 / 8_388_608.0 - 1.0
    }

    pub(crate) fn point(&mut self) -> Vec3 {
        vec3(self.next(), self.next(), self.next())
    }
}

pub(crate) fn parry(v: Vec3) -> Vector {
    Vector::from(v.to_array())
}

/// A wavy surface of 20 × 20 squares of 0.2 m.
pub(crate) fn grid() -> (Vec<Vec3>, Vec<[u32; 3]>) {
    let mut vertices = Vec::new();
    for i in 0..=20_u8 {
        for k in 0..=20_u8 {
            let (x, z) = (f32::from(i) * 0.2 - 2.0, f32::from(k) * 0.2 - 2.0);
            vertices.push(vec3(x, 0.3 * (x * x - z), z));
        }
    }
    let mut triangles = Vec::new();
    for i in 0..20 {
        for k in 0..20 {
            let a = i * 21 + k;
            triangles.extend([[a, a + 1, a + 22], [a, a + 22, a + 21]]);
        }
    }
    (vertices, triangles)
}
