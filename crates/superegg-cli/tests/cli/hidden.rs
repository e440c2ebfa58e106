//! Hidden children.

use crate::support::Sandbox;

#[test]
fn hidden_children_are_left_out_everywhere_and_stay_hidden_in_the_file() {
    let sandbox = Sandbox::new();
    let lines = "primitive ball\nobject pair\naddPrimitive ball left\ntranslate -2 0 0\naddPrimitive ball right\ntranslate 2 0 0\n";
    sandbox.write("both.scn", lines);
    let answer = sandbox.run_with("", &format!("{lines}hide left\nrenameChild right east\ninfo\ninfo pair\nshow\nsave s.scn\nexport s.csv\nintersect -2 0 9 0 0 -1\nintersect 2 0 9 0 0 -1\n"));
    let text = &answer.out;
    for part in [
        "pair: 2 children, 1 hidden",
        "child left (ball)  (hidden)",
        "child east (ball)  <- cursor",
        "pair: 1 instance",
        "left = ball  (hidden)",
        "pair/east",
    ] {
        assert!(text.contains(part), "{part}: {answer:?}");
    }
    let saved = sandbox.read("s.scn");
    assert!(saved.contains("addPrimitive ball left\ntranslate -2 0 0\nhide\n"), "{saved}");
    assert!(!sandbox.read("s.csv").contains("left") && sandbox.read("s.csv").contains("east"));
    assert_eq!(sandbox.run("export s.scn -o again.csv").code, Some(0));
    assert_eq!(sandbox.read("again.csv"), sandbox.read("s.csv"));
    // The picture is that of the scene without the child.
    sandbox.write("one.scn", lines.replace("addPrimitive ball left\ntranslate -2 0 0\n", ""));
    let picture = |name: &str| {
        sandbox.run(&format!("render {name}.scn --size 40x30 -o {name}.png --quiet")).fine();
        std::fs::read(sandbox.path(&format!("{name}.png"))).unwrap()
    };
    assert!(picture("s") == picture("one") && picture("s") != picture("both"));
    // A hidden child can be shown again, and both can be undone.
    let answer = sandbox
        .run_with("", "load s.scn\nunhide\ninfo\nundo\ninfo\nhide west\nhide\nshow\nrender a.png 8x8\n");
    assert!(
        answer.out.contains("pair: 2 children\n") && answer.out.contains("pair: 2 children, 1 hidden"),
        "{answer:?}"
    );
    assert!(answer.err.contains("'pair' has no child 'west'"), "{answer:?}");
    assert!(answer.out.contains("all children of 'pair' are hidden; 'unhide' shows them"), "{answer:?}");
}
