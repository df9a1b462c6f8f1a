//! Snapshots, recordings and journals.

use std::fs;
use std::path::Path;

use crate::common::folder;

use crate::running::{fail, json, scene_with, succeed};

/// The lines of a trace from a step on, below the header.
fn lines_from(trace: &Path, step: u64) -> Vec<String> {
    let text = fs::read_to_string(trace).unwrap();
    let is_later = |line: &&str| {
        let number = line.split(',').next().and_then(|n| n.parse::<u64>().ok());
        number.is_some_and(|n| n >= step)
    };
    text.lines().filter(is_later).map(str::to_owned).collect()
}

#[test]
fn a_run_goes_on_from_its_snapshot_as_if_it_had_not_been_interrupted() {
    let folder = folder("snapshot");
    fs::write(folder.join("box.gltf"), scene_with(&[])).unwrap();
    let run = |args: &str| succeed(&folder, &args.split(' ').collect::<Vec<_>>());
    for scene in ["wrecking_ball", "box.gltf"] {
        run(&format!("simulate {scene} --steps 90 --trace whole.csv --report whole.json"));
        run(&format!("simulate {scene} --steps 60 --snapshot at60.run --threads 1"));
        let told =
            run("simulate --resume at60.run --steps 30 --trace rest.csv --report rest.json \
             --snapshot at60.run --threads 2");
        assert!(told.contains("after 60 before"), "{told}");
        assert_eq!(
            lines_from(&folder.join("rest.csv"), 0),
            lines_from(&folder.join("whole.csv"), 60),
            "{scene}"
        );
        let [whole, rest] = ["whole.json", "rest.json"].map(|name| json(&folder.join(name)));
        assert_eq!(whole["hash"], rest["hash"], "{scene}");
        assert_eq!((rest["steps"].as_u64(), rest["from_step"].as_u64()), (Some(30), Some(60)));
        // The snapshot was replaced by one of step 90.
        let told =
            run(&format!("simulate --resume at60.run {scene} --steps 0 --set gravity=0,0,0"));
        assert!(told.contains("after 90 before"), "{told}");
    }

    let snapshot = fs::read(folder.join("at60.run")).unwrap();
    fs::write(folder.join("cut.run"), &snapshot[..snapshot.len() / 2]).unwrap();
    let mut changed = snapshot.clone();
    changed[snapshot.len() / 2] ^= 16;
    fs::write(folder.join("changed.run"), changed).unwrap();
    fs::write(folder.join("at60.json"), "{}").unwrap();
    for (args, why) in [
        ("cut.run", "cut off or changed"),
        ("changed.run", "cut off or changed"),
        ("at60.json", "is no snapshot"),
        ("missing.run", "cannot be read"),
        ("at60.run pyramid", "of another scene than pyramid"),
    ] {
        let line =
            fail(&folder, &format!("simulate --resume {args}").split(' ').collect::<Vec<_>>());
        assert!(line.contains(why), "{line}");
    }
    fs::remove_file(folder.join("box.gltf")).unwrap();
    let line = fail(&folder, &["simulate", "--resume", "at60.run"]);
    assert!(line.contains("box.gltf: no such file"), "{line}");
}

#[test]
fn a_journal_that_a_program_wrote_is_replayed() {
    use drystone::journal::{Call, Journal};
    use drystone::{BodyDef, ShapeDef, World};
    let folder = folder("journal");
    let mut world = World::default();
    let mut journal = Journal::begin(&world);
    let ball = BodyDef::dynamic().with_shape(ShapeDef::sphere(0.5));
    journal.call(&mut world, Call::AddBody(Box::new(ball))).unwrap();
    for _ in 0..3 {
        journal.call(&mut world, Call::Step(1.0 / 60.0)).unwrap();
    }
    let bytes = journal.to_bytes();
    fs::write(folder.join("ball.journal"), &bytes).unwrap();
    let told = succeed(&folder, &["replay", "ball.journal", "--threads", "2"]);
    assert!(told.contains("4 calls made again, 3 steps of them, every bit the same"), "{told}");
    fs::write(folder.join("cut.journal"), &bytes[..bytes.len() - 1]).unwrap();
    let line = fail(&folder, &["replay", "cut.journal"]);
    assert!(line.contains("cut.journal: the journal was cut off or changed"), "{line}");
}

#[test]
fn a_recorded_run_is_replayed_and_told_where_it_goes_another_way() {
    let folder = folder("record");
    let run = |args: &str| succeed(&folder, &args.split(' ').collect::<Vec<_>>());
    run("simulate wall:ball=1 --steps 40 --record run.log --threads 1");
    let told = run("replay run.log --threads 2");
    assert!(told.contains("40 steps run again, every bit the same"), "{told}");
    // From a snapshot, with other settings.
    run("simulate wall:ball=1 --steps 20 --snapshot at20.run");
    run("simulate --resume at20.run --steps 20 --set gravity=1,0,0 --record later.log");
    assert!(run("replay later.log").contains("20 steps run again"));

    // The same start, but another mass: it shows where the box meets the floor.
    fs::write(folder.join("box.gltf"), scene_with(&[])).unwrap();
    run("simulate box.gltf --steps 60 --record box.log");
    assert!(run("replay box.log").contains("60 steps run again"));
    fs::write(folder.join("box.gltf"), scene_with(&[("MASS", "2.0")])).unwrap();
    let line = fail(&folder, &["replay", "box.log"]);
    assert!(line.contains("stage solver") && line.contains("'a \"box\", falling'"), "{line}");
    fs::write(folder.join("box.gltf"), scene_with(&[("HEIGHT", "1.5")])).unwrap();
    let line = fail(&folder, &["replay", "box.log"]);
    assert!(line.contains("before the first step"), "{line}");

    let log = fs::read(folder.join("run.log")).unwrap();
    assert!(!told.contains("cut off"), "{told}");
    // The end, with its head of 12 bytes, counts 40 steps.
    let end = 12 + 1 + "whole log".len() + 1;
    for (cut, steps) in [(3, 40), (end, 40), (end + 3, 39)] {
        fs::write(folder.join("cut.log"), &log[..log.len() - cut]).unwrap();
        let told = run("replay cut.log");
        assert!(told.contains(&format!("{steps} steps run again, every bit the same")), "{told}");
        assert!(told.contains("the log is cut off there"), "{told}");
    }
    fs::write(folder.join("short.log"), &log[..40]).unwrap();
    assert!(fail(&folder, &["replay", "short.log"]).contains("cut off or changed"));
    assert!(fail(&folder, &["replay", "at20.run"]).contains("is no log"));
}
