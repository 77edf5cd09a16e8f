use super::*;

fn folder(name: &str, files: &[(&str, &[u8])]) -> PathBuf {
    let folder = std::env::temp_dir().join(format!("jostle-folder-{name}-{}", std::process::id()));
    let _ = std::fs::remove_dir_all(&folder);
    std::fs::create_dir_all(&folder).unwrap();
    for (name, text) in files {
        std::fs::write(folder.join(name), text).unwrap();
    }
    folder
}

const SCENE: &str = r#"{"version": 1, "bodies": [{"block": "cube", "pose": {"x": 0.5, "y": 0}}], "target": 0}"#;

/// Every file of the folder is either a problem or refused, whatever is done to it.
#[test]
fn every_file_is_a_problem_or_refused_with_its_reason() {
    let goal = SCENE.replace("}}], \"target\": 0", "}, \"goal\": {\"pose\": {\"x\": 0.4, \"y\": 0}}}]");
    let clear = SCENE.replace("\"target\": 0", "\"clear\": true");
    for (kind, text) in [SCENE, &goal, &clear].into_iter().enumerate() {
        let marked = format!("\u{feff}{text}");
        let comma = format!("{},}}", &text[..text.len() - 1]);
        let deep = format!("{{\"x\": {}{}, {}", "[".repeat(100), "]".repeat(100), &text[1..]);
        let (mut latin, mut wide) = (text.as_bytes().to_vec(), vec![0xff, 0xfe]);
        latin.splice(1..1, *b"\"name\": \"\xe9\", ");
        wide.extend(text.bytes().flat_map(|b| [b, 0]));
        let folder = folder(
            &format!("kinds-{kind}"),
            &[
                ("a.json", text.as_bytes()),
                ("b.JSON", text.as_bytes()),
                ("c.Json", marked.as_bytes()),
                ("d.json", comma.as_bytes()),
                ("e.json", &latin),
                ("f.json", &wide),
                ("g.json", b""),
                ("h.json", &text.as_bytes()[..text.len() / 2]),
                ("i.json", deep.as_bytes()),
                ("j.txt", b"cube.urdf 0 0 0 0.5 0\n"),
                ("k.txt", text.as_bytes()),
                ("l.json", text.replace("\"version\": 1, ", "").as_bytes()),
                ("notes.md", b"no scene"),
            ],
        );
        let problems = Problems::open(&folder, None).unwrap();
        let counts = [problems.retrievals.len(), problems.rearrangements.len(), problems.clearings.len()];
        std::fs::remove_dir_all(&folder).unwrap();
        assert_eq!(counts, std::array::from_fn(|k| if k == kind { 4 } else { 0 }), "a, b, c and k");
        for (refused, wanted) in problems.refused.iter().zip([
            ("d", "trailing comma (line 1, column "),
            ("e", "d.json"),
            ("f", "is UTF-16; save it as UTF-8"),
            ("g", "scene: EOF while parsing a value (line 1, column 0)"),
            ("h", "(line 1, column "),
            ("i", "x: unknown field `x`"),
            ("j", "line 1: has 6 columns"),
            ("l", "version: is missing; write `\"version\": 1` (line 1, column 1)"),
        ]) {
            let wanted = if refused.name == "e" { ("e", "byte 0xe9 is not UTF-8 (line 1, column 11)") } else { wanted };
            assert_eq!(refused.name, wanted.0);
            assert!(refused.reason.contains(wanted.1), "{refused:?}");
        }
        assert_eq!(problems.refused.len(), 8, "{:?}", problems.refused);
    }
}

#[test]
fn problems_of_another_kind_are_refused_and_not_dropped() {
    let goal = SCENE.replace("}}], \"target\": 0", "}, \"goal\": {\"pose\": {\"x\": 0.4, \"y\": 0}}}]");
    let clear = SCENE.replace("\"target\": 0", "\"clear\": true");
    let plan = "{\"plan_version\": 1}";
    let files = [("a.json", SCENE), ("b.json", &goal), ("c.json", &clear), ("d.json", &clear), ("e.json", plan)];
    for (of, kept, refused) in [(&files[..], [0, 1, 0], 4), (&files[2..], [0, 0, 2], 1), (&files[..1], [1, 0, 0], 0)] {
        let of: Vec<(&str, &[u8])> = of.iter().map(|(name, text)| (*name, text.as_bytes())).collect();
        let folder = folder("mixed", &of);
        let problems = Problems::open(&folder, None).unwrap().of_one_kind();
        std::fs::remove_dir_all(&folder).unwrap();
        let counts = [problems.retrievals.len(), problems.rearrangements.len(), problems.clearings.len()];
        assert_eq!((counts, problems.refused.len()), (kept, refused), "{:?}", problems.refused);
        assert_eq!(counts.iter().sum::<usize>() + refused, of.len());
    }
}

/// The published names of the arrangements, and what a folder may have of them.
#[test]
fn arrangements_are_found_by_their_content_and_what_has_no_partner_is_refused() {
    let discs = |count: usize, y: usize| {
        let points: Vec<String> = (0..count).map(|i| format!("[{}, {y}]", 60 + 110 * i)).collect();
        format!(
            "{{\"Object_Shape\": \"disc\", \"Object_Radius\": 50, \"Workspace_Width\": 1000, \"Workspace_Height\": 1000, \
             \"point_list\": [{}]}}",
            points.join(", ")
        )
    };
    let names = ["0_8_0.3.json", "1_8_0.3.json", "2_8_0.3.JSON", "3_8_0.3.json", "4_8_0.3.json", "6_3_0.1.json"];
    let texts: Vec<String> = names.iter().enumerate().map(|(i, _)| discs(8, 100 + 100 * i)).collect();
    let mut files: Vec<(&str, &[u8])> = names.iter().copied().zip(texts.iter().map(|t| t.as_bytes())).collect();
    let (fewer, broken) = (discs(3, 700), discs(3, 500).replace("]]", "],]"));
    files.extend([
        ("7_3_0.1.json", fewer.as_bytes()),
        ("8_3_0.1.json", fewer.as_bytes()),
        ("9_3_0.1.json", broken.as_bytes()),
    ]);
    let folder = folder("trlb", &files);
    let problems = Problems::open(&folder, None).unwrap().of_one_kind();
    std::fs::remove_dir_all(&folder).unwrap();
    let found: Vec<_> = problems.rearrangements.iter().map(|p| p.name.rsplit('/').next().unwrap()).collect();
    assert_eq!(found, ["0_8_0.3-1_8_0.3", "2_8_0.3-3_8_0.3"]);
    for (refused, (name, reason)) in problems.refused.iter().zip([
        ("4_8_0.3", "has no other half"),
        ("6_3_0.1", "are not of the same objects"),
        ("8_3_0.1", "9_3_0.1.json: point_list: trailing comma"),
    ]) {
        assert!(refused.name == name && refused.reason.contains(reason), "{refused:?}");
    }
    assert_eq!(problems.refused.len(), 3, "{:?}", problems.refused);
}
