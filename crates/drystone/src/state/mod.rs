//! Layer 2: the tables, which hold all state that lives between steps, and the definitions from
//! which rows are made.

pub(crate) mod def;
pub(crate) mod glue;
pub(crate) mod fracture;
pub(crate) mod breakage;
pub(crate) mod six_dof;
pub(crate) mod events;
pub(crate) mod articulations;
pub(crate) mod bodies;
pub(crate) mod shapes;
pub(crate) mod joints;
pub(crate) mod chains;
pub(crate) mod particles;
pub(crate) mod contacts;
pub(crate) mod coupling;
pub(crate) mod bounds;
pub(crate) mod colors;
pub(crate) mod islands;
pub(crate) mod sets;
pub(crate) mod tables;
pub(crate) mod validity;
