#![allow(clippy::unwrap_used, reason = "a test may panic")]
use super::*;
use std::path::PathBuf;

mod schema;

choices! {
    /// Words.
    pub enum Shape {
        /// One.
        #[default]
        Round = "round",
        /// Two.
        Square = "square",
    }
}

settings! {
    /// Every type that a setting can have.
    pub struct Everything {
        /// A number,
        /// said in two lines.
        number_m: f32 = 0.1, in 0.1..=10.0, unit "m", needs "everything.flag=true";
        /// A count.
        count: u32 = 3, in 1..;
        /// A whole number.
        offset: i32 = -1, in ..=5;
        /// Yes or no.
        flag: bool = false;
        /// A word.
        shape: Shape = Shape::Square;
        /// A colour.
        color: LinearColor = LinearColor([1.0, 0.0, 0.0]);
        /// A vector.
        direction: [f32; 3] = [0.0, 1.0, 0.0], in -1.0..=1.0;
        /// Whole numbers.
        size_px: [u32; 2] = [4, 8];
        /// A text.
        text: String = "a, b".into();
        /// A path.
        file: PathBuf = PathBuf::from("a.ktx2");
        /// Numbers.
        levels: Vec<f32> = vec![0.5, 1.0], in 0.0..=1.0;
        /// Words.
        shapes: Vec<Shape> = Vec::new();
    }
}

fn infos() -> Vec<SettingInfo> {
    Everything::declared().into_iter().map(|info| info.of_group("everything")).collect()
}

fn give(group: &mut Everything, key: &str, written: &SettingInput) -> Result<(), SettingsError> {
    let infos = infos();
    let info = infos.iter().find(|info| info.key == key);
    let info = info.ok_or_else(|| unknown_key(key, infos.iter().map(|info| &*info.key)))?;
    group.give(key.strip_prefix("everything.").unwrap(), info, written)
}

fn set(group: &mut Everything, key: &str, text: &str) -> Result<(), String> {
    give(group, &format!("everything.{key}"), &text.into()).map_err(|error| error.to_string())
}

#[test]
fn a_declaration_tells_everything() {
    let infos = infos();
    let info = |key: &str| infos.iter().find(|info| info.key == format!("everything.{key}")).unwrap();
    let number = info("number_m");
    assert_eq!((number.min, number.max, number.unit.as_deref()), (Some(0.1), Some(10.0), Some("m")));
    assert_eq!(
        (&*number.doc, &number.needs[..]),
        ("A number, said in two lines.", &["everything.flag=true".into()][..])
    );
    assert_eq!(number.default.as_ref().unwrap().to_string(), "0.1");
    assert_eq!((info("count").min, info("count").max), (Some(1.0), Some(u32::MAX.into())));
    assert_eq!((info("offset").min, info("offset").max), (Some(i32::MIN.into()), Some(5.0)));
    let types: Vec<String> = infos.iter().map(|info| info.kind.to_string()).collect();
    let expected = "f32 u32 i32 bool choice color vec3f vec2u text path list of f32 list of choice";
    assert_eq!(types.join(" "), expected);
    assert_eq!(info("shapes").choices, ["round", "square"]);
}

#[test]
fn every_type_takes_text() {
    let mut group = Everything::default();
    for (key, text) in [
        ("number_m", "10"),
        ("count", "4294967295"),
        ("offset", "-2147483648"),
        ("flag", "true"),
        ("shape", "round"),
        ("color", "#00ff00"),
        ("direction", "-1, 0.5,1"),
        ("size_px", "1,2"),
        ("text", "x, y"),
        ("file", "b/c.exr"),
        ("levels", "0,0.25,1"),
        ("shapes", "square,round,square"),
    ] {
        set(&mut group, key, text).unwrap();
    }
    let expected = Everything {
        number_m: 10.0,
        count: u32::MAX,
        offset: i32::MIN,
        flag: true,
        shape: Shape::Round,
        color: LinearColor([0.0, 1.0, 0.0]),
        direction: [-1.0, 0.5, 1.0],
        size_px: [1, 2],
        text: "x, y".into(),
        file: "b/c.exr".into(),
        levels: vec![0.0, 0.25, 1.0],
        shapes: vec![Shape::Square, Shape::Round, Shape::Square],
    };
    assert_eq!(group, expected);
    set(&mut group, "levels", "").unwrap();
    set(&mut group, "color", "0.25,2,0").unwrap();
    assert_eq!((group.levels.len(), group.color), (0, LinearColor([0.25, 2.0, 0.0])));
}

#[test]
fn the_command_line_takes_the_arrays_of_files_too() {
    let mut group = Everything::default();
    for (key, text) in [
        ("levels", "[0, 0.25,1]"),
        ("shapes", " [\"round\", 'square',] "),
        ("direction", "[-1, 0.5, 1]"),
        ("size_px", "[1, 0x10]"),
        ("color", "[0.25, 2, 0]"),
        // What takes a text takes it as it is.
        ("text", "[\"x\"]"),
        ("file", "[1]"),
    ] {
        set(&mut group, key, text).unwrap();
    }
    assert_eq!((&group.levels[..], &group.shapes[..]), (&[0.0, 0.25, 1.0][..], &[Shape::Round, Shape::Square][..]));
    assert_eq!((group.direction, group.size_px), ([-1.0, 0.5, 1.0], [1, 16]));
    assert_eq!((&*group.text, group.color), ("[\"x\"]", LinearColor([0.25, 2.0, 0.0])));
    assert_eq!(group.file.to_str(), Some("[1]"));
    set(&mut group, "levels", "[]").unwrap();
    assert!(group.levels.is_empty());
    for (key, text) in [
        ("levels", "[0, 2]"),
        ("levels", "[0, [1]]"),
        ("levels", "[0, 1"),
        ("levels", "[0]\nother = [1]"),
        ("shapes", "[round]"),
        ("shapes", "[\"oval\"]"),
        ("direction", "[0, 1]"),
        ("number_m", "[1]"),
    ] {
        let error = set(&mut group, key, text).unwrap_err();
        assert!(error.contains(&format!("`{text}` is not a value of `everything.{key}`")), "{key}={text}: {error}");
    }
}

#[test]
fn what_is_no_value_is_refused_with_type_and_range() {
    let mut group = Everything::default();
    for (key, text, expected) in [
        ("number_m", "0.09", "which takes a number from 0.1 to 10"),
        ("number_m", "nan", "a number from"),
        ("number_m", "1,2", "`1,2` is not a value"),
        ("count", "0", "a whole number from 1 to 4294967295"),
        ("count", "1.5", "a whole number"),
        ("offset", "6", "a whole number from -2147483648 to 5"),
        ("flag", "yes", "true or false"),
        ("shape", "oval", "round or square"),
        ("color", "12345", "a colour such as ff8800"),
        ("color", "1,-1,0", "at least 0"),
        ("color", "+12345", "a colour"),
        ("direction", "0,1", "3 numbers with commas between, each from -1 to 1"),
        ("direction", "0,1,2", "each from -1 to 1"),
        ("size_px", "1,-1", "2 whole numbers"),
        ("levels", "0.5,1.5", "a list; each entry is a number from 0 to 1"),
        ("levels", "0.5,", "a list"),
        ("shapes", "round,oval", "a list; each entry is round or square"),
    ] {
        let error = set(&mut group, key, text).unwrap_err();
        assert!(error.contains(expected), "{key}={text}: {error}");
    }
    assert_eq!(group, Everything::default());
    assert!(set(&mut group, "shap", "round").unwrap_err().ends_with("did you mean `everything.shape`?"));
}

#[test]
fn files_keep_the_parts_of_lists_apart_and_defaults_come_back() {
    let read = |text: &str| -> Result<Everything, String> {
        let mut group = Everything::default();
        let file = SettingsFile::parse("a.toml", text).map_err(|error| error.to_string())?;
        file.apply(|key, written| give(&mut group, key, written)).map_err(|error| error.to_string())?;
        Ok(group)
    };
    let text = "[everything]\nflag = true\ndirection = [0, 0.5, -1]\ncolor = \"ff8800\"\nlevels = [0.5]\n\
                shapes = [\"round\"]\ntext = \"a, b\"\nsize_px = [1, 0x10]\nnumber_m = 0.1";
    let group = read(text).unwrap();
    assert!(group.flag && group.direction == [0.0, 0.5, -1.0] && group.size_px == [1, 16], "{group:?}");
    assert_eq!((group.levels, group.shapes), (vec![0.5], vec![Shape::Round]));
    let error = read("[everything]\nlevels = [0.5, 2]").unwrap_err();
    assert!(error.starts_with("a.toml:2:10: error: `[0.5,2]` is not a value of `everything.levels`"), "{error}");
    assert!(read("everything.flag = [true]").unwrap_err().contains("true or false"));

    // Every default is a value of its own text, and of its own JSON.
    let mut group = Everything { text: String::new(), levels: vec![], ..Everything::default() };
    for info in infos() {
        let text = info.default.as_ref().unwrap().to_string();
        give(&mut group, &info.key, &text.as_str().into()).unwrap();
    }
    assert_eq!(group, Everything::default());
    let json = serde_json::to_string(&group).unwrap();
    assert_eq!(serde_json::from_str::<Everything>(&json).unwrap(), group);
    let error = serde_json::from_str::<Everything>(r#"{ "number_m": 11 }"#).unwrap_err().to_string();
    assert!(error.contains("a number from 0.1 to 10"), "{error}");
    assert!(serde_json::from_str::<Everything>(r#"{ "shap": "round" }"#).unwrap_err().to_string().contains("`shape`"));
}

#[test]
fn the_schema_says_the_same() {
    let infos = infos();
    let schema = schema(&infos);
    let table = &schema["properties"]["everything"];
    assert_eq!((&schema["additionalProperties"], &table["additionalProperties"]), (&false.into(), &false.into()));
    let of = |name: &str| &table["properties"][name];
    let expected = serde_json::json!({
        "type": "number", "minimum": 0.1, "maximum": 10, "default": 0.1,
        "description": "A number, said in two lines. Unit: m. Needs everything.flag=true."
    });
    assert_eq!(*of("number_m"), expected);
    assert_eq!(of("count")["type"], "integer");
    assert_eq!(of("direction")["minItems"], 3);
    assert_eq!(of("direction")["items"]["maximum"], 1);
    assert_eq!(of("shapes")["items"]["enum"], serde_json::json!(["round", "square"]));
    assert_eq!(of("levels")["items"]["maximum"], 1);
    assert_eq!(of("color")["anyOf"][0]["pattern"], LinearColor::PATTERN);
    assert_eq!(of("flag")["default"], false);
}
