//! Tests each check on a small correct tree, and on the same tree with one error.

use std::collections::BTreeMap;

use super::rust::Source;
use super::{Tree, comments, docs, examples, house, imports, layers, owners, source, stages};

fn tree(files: &[(&str, &str)]) -> Tree {
    let own = |(path, text): &(&str, &str)| ((*path).to_owned(), (*text).to_owned());
    Tree { files: files.iter().map(own).collect::<BTreeMap<_, _>>() }
}

fn layer_findings(path: &str, text: &str) -> Vec<String> {
    layers::check(&tree(&[(&format!("crates/drystone/src/{path}"), text)]))
}

const STEP: &str = "
use crate::state::Tables;
mod broadphase;
// solver::never(
pub(crate) fn step(tables: &mut Tables) {
    broadphase::find_pairs(tables);
    narrowphase::update(tables);
    partition::apply(tables, |x| { x });
    particles::meet(tables);
    solver::prepare(tables);
    solver::solve(tables);
    finalize::advance_poses(tables);
    sweep::stop(tables);
    sleep::rest(tables);
    report::report(tables);
}
fn after() { broadphase::again(); }
";

const PAGE: &str = "# Architecture
1. nothing
## The step
1. **broadphase**: pairs
2. **narrowphase**: manifolds
3. `partition`: islands
4. particles
5. solver
6. finalize
7. sweep
8. sleep
9. report
10. breakage
## Other
1. base
";

fn stage_findings(step: &str, page: &str) -> Vec<String> {
    stages::check(&tree(&[("crates/drystone/src/step/mod.rs", step), ("ARCHITECTURE.md", page)]))
}

#[test]
fn layer_may_use_itself_and_those_above() {
    let text =
        "use crate::base::Vec3;\nuse crate::state::{self, Bodies};\nuse super::context::C;\n";
    assert_eq!(layer_findings("step/solver/mod.rs", text), [""; 0]);
    assert_eq!(layer_findings("world/mod.rs", "use crate::{step, query::ray, Error};"), [""; 0]);
    assert_eq!(layer_findings("lib.rs", "pub use crate::world::World;"), [""; 0]);
}

#[test]
fn back_edge_of_the_layers_is_found() {
    let found = layer_findings("geometry/hull.rs", "\nuse crate::{base::Vec3, state::{A, B}};\n");
    assert_eq!(found, ["crates/drystone/src/geometry/hull.rs:2: geometry may not use state"]);
    assert_eq!(layer_findings("step/mod.rs", "use crate::query::Ray;").len(), 1);
    assert_eq!(layer_findings("query/mod.rs", "fn f() { crate::step::step() }").len(), 1);
    assert_eq!(layer_findings("base/math.rs", "pub(in crate::world) fn f() {}").len(), 1);
}

#[test]
fn super_that_leaves_the_layer_is_followed() {
    assert_eq!(layer_findings("base/mod.rs", "use super::geometry::Hull;").len(), 1);
    assert_eq!(layer_findings("state/bodies.rs", "use super::super::world::World;").len(), 1);
    assert_eq!(layer_findings("state/bodies.rs", "use super::super::{base, step};").len(), 1);
    assert_eq!(layer_findings("state/bodies.rs", "use super::world::Own;"), [""; 0]);
}

#[test]
fn root_reexports_and_unknown_modules_are_no_way_around() {
    assert_eq!(layer_findings("state/bodies.rs", "use crate::World;").len(), 1);
    assert_eq!(layer_findings("state/bodies.rs", "crate::id_type!(A);"), [""; 0]);
    assert_eq!(layer_findings("utils/mod.rs", "").len(), 1);
}

#[test]
fn unit_tests_comments_and_strings_may_name_any_layer() {
    let text = "//! [`crate::world`]\nconst A: &str = \"crate::world::B\";\n\
                #[cfg(test)]\nmod tests {\n use crate::world::World;\n}\n";
    assert_eq!(layer_findings("base/mod.rs", text), [""; 0]);
    assert_eq!(layer_findings("base/tests.rs", "use crate::world::World;"), [""; 0]);
    let after = "#[cfg(test)]\nuse crate::world::World;\nuse crate::step::X;\n";
    assert_eq!(layer_findings("base/mod.rs", after).len(), 1);
}

#[test]
fn stages_in_the_listed_order_pass() {
    assert_eq!(stage_findings(STEP, PAGE), [""; 0]);
}

#[test]
fn swapped_missing_or_absent_stages_are_found() {
    let swapped = PAGE.replace("8. sleep", "8. report").replace("9. report", "9. sleep");
    let found = stage_findings(STEP, &swapped);
    assert!(found.len() == 1 && found[0].contains("sleep, report, breakage, but"), "{found:?}");
    let found = stage_findings(&STEP.replace("sweep::stop(tables);", ""), PAGE);
    assert_eq!(found, ["crates/drystone/src/step/mod.rs:1: the stage `sweep` is missing"]);
    assert_eq!(stage_findings(STEP, &PAGE.replace("7. sweep\n", "")).len(), 1);
    assert_eq!(stage_findings(&STEP.replace("sleep::rest(", "sleep::REST; ("), PAGE).len(), 1);
    assert_eq!(stage_findings(STEP, &PAGE.replace("9. report", "9. report\n10. draw")).len(), 1);
    assert_eq!(stage_findings("fn step() {}", "# Nothing").len(), 2);
    assert_eq!(stages::check(&tree(&[])).len(), 2);
}

#[test]
fn unknown_reference_key_is_found() {
    let references = ("docs/references.md", "- **[Catto11]** Soft constraints.\n");
    let good = ("a.rs", "// [Catto11] p. 24\nlet x = row[Abc12];\n");
    assert_eq!(docs::check(&tree(&[references, good])), [""; 0]);
    let bad = ("a.rs", "\n// [Catto12], and [`Pose`] [A12] [Abc123] are no keys\n");
    assert_eq!(
        docs::check(&tree(&[references, bad])),
        ["a.rs:2: [Catto12] is not in docs/references.md"]
    );
    let twice = ("docs/references.md", "- [Catto11] a\n- [Catto11] b\n");
    assert_eq!(docs::check(&tree(&[twice])).len(), 1);
}

#[test]
fn missing_doc_page_is_found() {
    let page = ("docs/derivations/row.md", "");
    let good = ("a.rs", "#![doc = include_str!(\"../../docs/derivations/row.md\")]\n");
    let good_page = ("A.md", "See docs/derivations/row.md. Also <https://docs.rs/x.md>.");
    assert_eq!(docs::check(&tree(&[page, good, good_page])), [""; 0]);
    assert_eq!(docs::check(&tree(&[good, ("A.md", "`docs/gone.md`")])).len(), 2);
}

#[test]
fn dead_link_is_found() {
    let good = ("docs/a.md", "[up](../README.md#top) [in](#here) [out](https://x.org/y) [dir](b/)");
    let all = [("README.md", ""), good, ("docs/b/c.md", "")];
    assert_eq!(docs::check(&tree(&all)), [""; 0]);
    let found = docs::check(&tree(&[("README.md", "\n[a](LICENSE)")]));
    assert_eq!(found, ["README.md:2: the link to LICENSE leads nowhere"]);
}

#[test]
fn dead_definition_of_a_link_is_found() {
    let page = "See [b] and a slice `x[0]: f32`.\n\n[b]: b.md\n[c]: https://x.org/y\n";
    assert_eq!(docs::check(&tree(&[("m/a.md", page), ("m/b.md", "")])), [""; 0]);
    let found = docs::check(&tree(&[("m/a.md", page)]));
    assert_eq!(found, ["m/a.md:3: the link to b.md leads nowhere"]);
    assert_eq!(docs::check(&tree(&[("A.md", "`manual/gone.md`")])).len(), 1);
    assert_eq!(
        docs::check(&tree(&[("A.md", "`manual/a.md`"), ("crates/drystone/manual/a.md", "")])),
        [""; 0]
    );
}

#[test]
fn name_without_an_example_and_page_without_a_chapter_are_found() {
    let face = "pub mod manual;\npub mod query;\npub use world::{World, Clock};\n\
                pub mod joint {\n    pub use state::Hinge;\n}\n/// ```\n/// joint(Hinge)\n/// ```\n";
    let files = [
        ("crates/drystone/src/lib.rs", face),
        ("crates/drystone/src/query/mod.rs", "pub struct Ray;\nimpl Ray {\n    pub fn f() {}\n}\n"),
        ("crates/drystone/src/manual.rs", "include_str!(\"../manual/a.md\")"),
        ("crates/drystone/manual/a.md", "```rust\n# World\nquery(Ray)\n```\n"),
        ("crates/drystone/examples/hello.rs", "// World\nfn main() { Clock }\n"),
    ];
    assert_eq!(examples::check(&tree(&files)), [""; 0]);
    let mut less = files;
    less[3].1 = "World\n```text\nWorld\n```\n```rust\n// World\nquery(Ray)\n```\n";
    let found = examples::check(&tree(&less));
    assert!(found.len() == 1 && found[0].contains("lib.rs:3: `World` stands in no"), "{found:?}");
    less[3].1 = "```rust\nWorld; query\n```\n";
    assert!(examples::check(&tree(&less))[0].contains("query/mod.rs:1: `Ray` stands"));
    less = files;
    less[2].1 = "";
    let found = examples::check(&tree(&less));
    assert!(
        found.len() == 1 && found[0].starts_with("crates/drystone/manual/a.md:1: "),
        "{found:?}"
    );
    less = files;
    less[3].1 = "```rust\nWorld; query(Ray)\n```\n[b c]: b.md\n";
    let found = examples::check(&tree(&less));
    assert_eq!(
        found,
        [
            "crates/drystone/manual/a.md:4: the label [b c] is not in crates/drystone/manual/links.txt"
        ]
    );
    let links = ("crates/drystone/manual/links.txt", "<!-- -->\n[b c]: crate::b\n");
    assert_eq!(examples::check(&tree(&[&less[..], &[links]].concat())), [""; 0]);
}

#[test]
fn readme_example_is_the_crate_example() {
    let readme = ("README.md", "<!-- hello -->\n```rust\nlet a = 1;\n\nf(a);\n```\n");
    let face = "//! # drystone\n//! ```\n//! # use x;\n//! let a = 1;\n//!\n//! f(a);\n//! ```\n";
    assert_eq!(docs::check(&tree(&[readme, ("crates/drystone/src/lib.rs", face)])), [""; 0]);
    let other = face.replace("f(a)", "g(a)");
    assert_eq!(docs::check(&tree(&[readme, ("crates/drystone/src/lib.rs", &other)])).len(), 1);
    assert_eq!(docs::check(&tree(&[("README.md", "<!-- hello -->\n")])), [""; 0]);
}

#[test]
fn unsafe_stands_only_in_base() {
    let text = "#![deny(unsafe_code)]\n// unsafe\nfn f() { unsafe { g() } }\n";
    assert_eq!(source::check(&tree(&[("crates/drystone/src/base/team.rs", text)])), [""; 0]);
    assert_eq!(source::check(&tree(&[("crates/drystone/tests/it/main.rs", text)])), [""; 0]);
    let found = source::check(&tree(&[("crates/drystone/src/world/mod.rs", text)]));
    assert_eq!(
        found,
        ["crates/drystone/src/world/mod.rs:3: `unsafe` outside crates/drystone/src/base/"]
    );
    let promise = "fn f() { lend(unsafe { Apart::promise() }) }\n";
    assert_eq!(source::check(&tree(&[("crates/drystone/src/step/mod.rs", promise)])), [""; 0]);
    assert_eq!(source::check(&tree(&[("crates/drystone-scene/src/lib.rs", promise)])).len(), 1);
    let more = promise.replace("()", "(g())");
    assert_eq!(source::check(&tree(&[("crates/drystone/src/step/mod.rs", &more)])).len(), 1);
}

#[test]
fn long_file_is_found_and_its_tests_do_not_count() {
    let code = "fn f() {}\n".repeat(600);
    let tested = format!("{code}#[cfg(test)]\nmod tests {{\n{code}}}\n");
    assert_eq!(source::check(&tree(&[("crates/a/src/a.rs", &tested)])), [""; 0]);
    let longer = format!("{tested}fn g() {{}}\n");
    assert_eq!(source::check(&tree(&[("crates/a/src/a.rs", &longer)])).len(), 1);
}

#[test]
fn note_for_later_needs_an_issue() {
    let note = note();
    let good = format!("// {note}(#12): faster\nlet s = \"{note}\";\n");
    assert_eq!(source::check(&tree(&[("a.rs", &good)])), [""; 0]);
    for bad in [format!("// {note}: x"), format!("/* {note}(#) */"), format!("// {note} #3")] {
        assert_eq!(source::check(&tree(&[("a.rs", &bad)])).len(), 1, "{bad}");
    }
}

fn note() -> String {
    ["TO", "DO"].concat()
}

#[test]
fn lexer_tells_code_from_the_rest() {
    let text = "f('\"', 'a', '\\'', '\\u{41}'); // c \"s\"\nlet x: &'a str = r#\"raw \" // \"#; /* a /* b */ \"c\" */ g(\"\\\"\");é\n";
    let parts = Source::new(text);
    assert_eq!(parts.code.len(), text.len());
    assert_eq!(parts.comments.split_whitespace().collect::<String>(), "//c\"s\"/*a/*b*/\"c\"*/");
    assert_eq!(parts.strings.split_whitespace().collect::<String>(), "r#\"raw\"//\"#\"\\\"\"");
    assert!(parts.code.contains("'\"', 'a'") && parts.code.contains("g("));
}

#[test]
fn comments_that_hide_their_subject_or_run_wide_are_found() {
    let found = |text: &str| comments::check(&tree(&[("a.rs", text)]));
    assert_eq!(found("/// Bodies of a world.\nfn f() {}\n"), [""; 0]);
    assert_eq!(found("/// What it is.\n").len(), 1);
    assert_eq!(found("    // Of these the first.\n").len(), 1);
    assert_eq!(found("let a = \"// What\"; // Whatever fits\n"), [""; 0]);
    assert_eq!(found(&format!("// {}\n", "a".repeat(98))).len(), 1);
    assert_eq!(found(&format!("// {}\n", "ω".repeat(97))), [""; 0]);
    let example = format!("/// ```\n/// {}\n/// ```\n", "a".repeat(120));
    assert_eq!(found(&example), [""; 0]);
    assert_eq!(found(&format!("// https://{}\n", "a".repeat(120))), [""; 0]);
}

const IMPORTS: [(&str, &str); 5] = [
    ("crates/drystone/src/step/mod.rs", "mod a;\nmod b;\nmod c;\nuse self::a::A;\n"),
    ("crates/drystone/src/step/a/mod.rs", "use super::b::B;\npub struct A;\n"),
    ("crates/drystone/src/step/b.rs", "use super::A;\npub struct B;\n"),
    ("crates/drystone/src/step/c.rs", "fn f() { super::b::B::g() }\n"),
    ("crates/drystone/src/lib.rs", "mod step;\n"),
];

#[test]
fn imports_are_followed_to_where_a_name_is_defined() {
    let arrows = imports::arrows(&tree(&IMPORTS));
    let to = |file: &str| -> Vec<String> {
        let to = &arrows[&format!("crates/drystone/src/step/{file}")];
        to.iter().map(|path| path.replace("crates/drystone/src/step/", "")).collect()
    };
    assert_eq!((to("mod.rs"), to("c.rs")), (vec!["a/mod.rs".to_owned()], vec!["b.rs".to_owned()]));
    // Not to step/mod.rs, which imports the name itself.
    assert_eq!(to("b.rs"), ["a/mod.rs"]);
    let circles = imports::circles(&arrows);
    assert_eq!(circles.len(), 1);
    assert!(circles[0].iter().all(|file| file.ends_with("a/mod.rs") || file.ends_with("b.rs")));
}

#[test]
fn circles_over_folders_long_files_and_crowded_folders_are_found() {
    let found = house::check(&tree(&IMPORTS));
    assert!(found.len() == 1 && found[0].contains("over folders"), "{found:?}");
    let open = [IMPORTS[0], IMPORTS[1], (IMPORTS[2].0, "pub struct B;\n"), IMPORTS[3]];
    assert_eq!(house::check(&tree(&open)), [""; 0]);
    let long = "fn f() {}\n".repeat(501);
    assert_eq!(source::check(&tree(&[("crates/drystone/src/a.rs", &long)])).len(), 1);
    let names: Vec<String> = (0..21).map(|i| format!("crates/drystone/src/a/f{i}.rs")).collect();
    let files: Vec<(&str, &str)> = names.iter().map(|name| (name.as_str(), "")).collect();
    assert_eq!(house::check(&tree(&files)).len(), 1);
}

#[test]
fn a_page_without_its_tables_of_access_is_told_apart_from_one_with_old_ones() {
    let page = "a\n<!-- owners:begin, written by `cargo xtask owners` -->\n<!-- owners:end -->\n";
    assert_eq!(owners::check(&tree(&[("ARCHITECTURE.md", "no tables")])), [""; 0]);
    let found = owners::check(&tree(&[("ARCHITECTURE.md", page)]));
    assert!(found.len() == 1 && found[0].contains("no file"), "{found:?}");
}
