//! The contact graph: finds which body rests on which, the strongly connected components, and
//! levels from the ground up [Guendelman03].
//!
//! A body rests on another if it would move into it when forces act on it alone. Bodies that rest
//! on each other in a circle form one component and share a level. The level of any other body is
//! one above the highest body that it rests on. Bodies that cannot be pushed have level 0.

use super::rows::{Mover, Pair};

/// Memory kept from step to step.
#[derive(Clone, Debug, Default)]
pub(crate) struct Graph {
    /// (upper, lower), sorted.
    edges: Vec<(u32, u32)>,
    /// First edge of each body.
    first: Vec<u32>,
    /// Tarjan's search: visit order of each body, lowest order reached, and the stack of bodies
    /// without a component.
    order: Vec<u32>,
    low: Vec<u32>,
    stack: Vec<u32>,
    on_stack: Vec<bool>,
    /// Body and its next edge.
    calls: Vec<(u32, u32)>,
}

/// Not visited yet.
const NEW: u32 = u32::MAX;

impl Graph {
    /// Sets the levels of movers and pairs. Forces must have been added just before; `old_v` and
    /// `old_w` are the velocities before them.
    pub(crate) fn rate(&mut self, movers: &mut [Mover], pairs: &mut [Pair]) {
        self.find_edges(movers, pairs);
        self.number_components(movers);
        for pair in pairs {
            pair.level = movers[pair.a as usize].level.max(movers[pair.b as usize].level);
        }
    }

    fn find_edges(&mut self, movers: &[Mover], pairs: &[Pair]) {
        self.edges.clear();
        for pair in pairs {
            let (a, b) = (&movers[pair.a as usize], &movers[pair.b as usize]);
            for p in pair.points() {
                let old_a = a.old_v + a.old_w.cross(p.r_a);
                let old_b = b.old_v + b.old_w.cross(p.r_b);
                let new_a = a.v + a.w.cross(p.r_a);
                let new_b = b.v + b.w.cross(p.r_b);
                if !a.is_fixed() && !b.is_fixed() {
                    if pair.normal.dot(old_b - new_a) < 0.0 {
                        self.edges.push((pair.a, pair.b));
                    }
                    if pair.normal.dot(new_b - old_a) < 0.0 {
                        self.edges.push((pair.b, pair.a));
                    }
                }
            }
        }
        self.edges.sort_unstable();
        self.edges.dedup();
        self.first.clear();
        self.first.resize(movers.len() + 1, 0);
        for (upper, _) in &self.edges {
            self.first[*upper as usize + 1] += 1;
        }
        for i in 0..movers.len() {
            self.first[i + 1] += self.first[i];
        }
    }

    /// Tarjan's search, without recursion. Components finish after all those on which they rest, so
    /// each level is known when it is needed.
    fn number_components(&mut self, movers: &mut [Mover]) {
        let n = movers.len();
        self.order.clear();
        self.order.resize(n, NEW);
        self.low.clear();
        self.low.resize(n, NEW);
        self.on_stack.clear();
        self.on_stack.resize(n, false);
        self.stack.clear();
        let mut next = 0;
        for root in 0..n {
            if movers[root].is_fixed() {
                movers[root].level = 0;
                continue;
            }
            if self.order[root] != NEW {
                continue;
            }
            self.open(number(root), &mut next);
            while let Some((body, edge)) = self.calls.last().copied() {
                let i = body as usize;
                if edge < self.first[i + 1] {
                    if let Some(call) = self.calls.last_mut() {
                        call.1 += 1;
                    }
                    let below = self.edges[edge as usize].1 as usize;
                    if self.order[below] == NEW {
                        self.open(number(below), &mut next);
                    } else if self.on_stack[below] {
                        self.low[i] = self.low[i].min(self.order[below]);
                    }
                    continue;
                }
                self.calls.pop();
                if let Some((caller, _)) = self.calls.last() {
                    let caller = *caller as usize;
                    self.low[caller] = self.low[caller].min(self.low[i]);
                }
                if self.low[i] == self.order[i] {
                    self.close(body, movers);
                }
            }
        }
    }

    fn open(&mut self, body: u32, next: &mut u32) {
        let i = body as usize;
        (self.order[i], self.low[i]) = (*next, *next);
        *next += 1;
        self.stack.push(body);
        self.on_stack[i] = true;
        self.calls.push((body, self.first[i]));
    }

    /// Closes the component whose first body is `root`: all bodies above it on the stack.
    fn close(&mut self, root: u32, movers: &mut [Mover]) {
        let start = self.stack.iter().rposition(|b| *b == root).unwrap_or(0);
        let members = &self.stack[start..];
        let mut level = 0;
        for body in members {
            let i = *body as usize;
            let edges = self.first[i] as usize..self.first[i + 1] as usize;
            for (_, below) in &self.edges[edges] {
                // Bodies of the component itself are still on the stack.
                if !self.on_stack[*below as usize] {
                    level = level.max(movers[*below as usize].level);
                }
            }
        }
        for body in members {
            movers[*body as usize].level = level + 1;
        }
        for body in members {
            self.on_stack[*body as usize] = false;
        }
        self.stack.truncate(start);
    }
}

fn number(n: usize) -> u32 {
    u32::try_from(n).expect("fewer than 2^32 bodies")
}

#[cfg(test)]
mod tests {
    use super::Graph;
    use crate::base::math::{Vec3, vec3};
    use crate::step::classic::rows::{Mover, Pair, PairPoint};

    /// Bodies that fall from rest by 0.1 m/s, after the fixed one.
    fn bodies(n: usize) -> Vec<Mover> {
        let falling = Mover { inv_mass: Vec3::ONE, v: vec3(0.0, -0.1, 0.0), ..Mover::default() };
        let mut all = vec![falling; n + 1];
        all[0] = Mover::default();
        all
    }

    fn pair(a: u32, b: u32, normal: Vec3) -> Pair {
        let mut pair = Pair { a, b, normal, count: 1, ..Pair::default() };
        pair.points[0] = PairPoint::default();
        pair
    }

    fn levels(n: usize, mut pairs: Vec<Pair>) -> Vec<u32> {
        let mut movers = bodies(n);
        Graph::default().rate(&mut movers, &mut pairs);
        movers.iter().map(|m| m.level).collect()
    }

    #[test]
    fn a_column_has_a_level_a_box_whichever_way_its_pairs_are_told() {
        let up = Vec3::Y;
        let pairs = vec![pair(2, 3, up), pair(2, 1, -up), pair(0, 1, up)];
        assert_eq!(levels(3, pairs), [0, 1, 2, 3]);
    }

    #[test]
    fn what_rests_on_two_is_above_the_higher_one() {
        let up = Vec3::Y;
        // 1 and 2 on the ground, 3 on 2, and 4 on 1 and on 3.
        let pairs =
            vec![pair(0, 1, up), pair(0, 2, up), pair(2, 3, up), pair(1, 4, up), pair(3, 4, up)];
        assert_eq!(levels(4, pairs), [0, 1, 1, 2, 3]);
    }

    #[test]
    fn bodies_that_rest_on_each_other_in_a_circle_share_a_level() {
        // Three in a ring, each over the next one and under the last; a fourth on top of them.
        let slope = vec3(0.8, 0.6, 0.0);
        let pairs = vec![
            pair(0, 1, Vec3::Y),
            pair(1, 2, slope),
            pair(2, 3, slope),
            pair(3, 1, slope),
            pair(2, 4, Vec3::Y),
        ];
        let levels = levels(4, pairs);
        assert_eq!((levels[1], levels[2], levels[3], levels[4]), (1, 1, 1, 2));
    }
}
