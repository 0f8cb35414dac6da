use super::*;
use serde_json::Value;

fn parsed(text: &str) -> Result<Object, FormatError> {
    parse(text.as_bytes(), &Limits::DEFAULT)
}

#[test]
fn numbers_members_and_texts_come_out_as_they_came_in() {
    let text = concat!(
        r#"{"z":[1e400,-0.0,-0,0.1000000000000000055511151,1E5,1e+05,12345678901234567890123],"#,
        r#""a":{"":null,"b":true,"c":false},"é\n":"\"\\/ 😀","0":[],"o":{}}"#
    );
    let root = parsed(text).expect("sound");
    assert_eq!(root.to_string(), text);
    let names: Vec<&String> = root.keys().collect();
    assert_eq!(names, ["z", "a", "é\n", "0", "o"]);
    assert_eq!(root["z"][0].as_f64(), None, "more than a number can be");
    assert_eq!(root["z"][4].as_u64(), Some(100_000));
    assert_eq!((root["a"]["x"][3].as_str(), root["z"]["a"].as_index()), (None, None));
}

#[test]
fn a_name_that_comes_twice_has_its_last_value() {
    assert_eq!(parsed(r#"{"a":1,"b":2,"a":3}"#).expect("sound").to_string(), r#"{"a":3,"b":2}"#);
}

#[test]
fn texts_are_spelt_like_those_of_other_writers() {
    let all: String = ('\0'..='\u{7f}').chain(['\u{2028}', 'é', '\u{10ffff}']).collect();
    let value = object! { "a" => object! { "b" => Vec::<u32>::new(), "c" => object! {} },
    &*all => [Json::from(&*all), Json::from(vec![Some(1.5), None]), false.into()] };
    let text = value.to_string();
    let other: Value = serde_json::from_str(&text).expect("JSON");
    assert_eq!(other[&*all][0], *all);
    assert_eq!(parsed(&text).map(Json::Object), Ok(value));
    // Members in the order of their names, as any map of the other package has them.
    let sorted = parsed(&other.to_string()).expect("JSON");
    assert_eq!(sorted.to_string(), other.to_string());
    assert_eq!(format!("{sorted:#}"), serde_json::to_string_pretty(&other).expect("JSON"));
}

#[test]
fn floats_have_the_shortest_spelling() {
    let few = [(0.0, "0.0"), (-0.0, "-0.0"), (100.5, "100.5"), (1e-7, "1e-7"), (1e16, "1e+16")];
    for (number, text) in few.into_iter().chain([(-157.437_164_306_640_62, "-157.43716430664062")])
    {
        assert_eq!(Json::from(number).to_string(), text);
    }
    assert_eq!(Json::from(f64::NAN), Json::Null);
}

#[test]
fn what_is_no_json_is_refused_where_it_is() {
    for (text, location) in [
        ("{\"a\":\n  tru}", "line 2 column 4"),
        ("{\"a\":01}", "line 1 column 7"),
        ("{\"a\":[1,]}", "line 1 column 9"),
        ("{\"a\":1.}", "line 1 column 8"),
        ("{\"a\" 1}", "line 1 column 6"),
        ("{\"a\":\"\u{1}\"}", "line 1 column 8"),
        ("{\"a\":\"\\ud800\"}", ""),
        ("{} {}", "line 1 column 4"),
        ("{", ""),
        ("{'a':1}", ""),
        ("", ""),
    ] {
        let error = parsed(text).expect_err(text);
        assert_eq!(error.fault, Fault::Malformed, "{text}");
        assert!(location.is_empty() || error.location == location, "{text}: {error}");
    }
    assert!(parse(b"{\"a\":\"\xff\"}", &Limits::DEFAULT).is_err(), "not UTF-8");
    for text in ["[]", "1", "null", "\"{}\""] {
        assert!(parsed(text).expect_err(text).problem.contains("not an object"), "{text}");
    }
}

#[test]
fn nesting_and_numbers_of_values_are_bounded() {
    let nested = |depth: usize| format!("{{\"a\":{}{}}}", "[".repeat(depth), "]".repeat(depth));
    assert!(parsed(&nested(125)).is_ok());
    assert_eq!(parsed(&nested(126)).expect_err("deep").fault, Fault::Limit);
    let few = Limits { json_depth: 2, ..Limits::DEFAULT };
    assert!(parse(nested(1).as_bytes(), &few).is_ok());
    assert_eq!(parse(nested(2).as_bytes(), &few).expect_err("deep").fault, Fault::Limit);
    let many = format!("{{\"a\":[0{}]}}", ",0".repeat(MAX_VALUES));
    assert_eq!(parsed(&many).expect_err("many").fault, Fault::Limit);
    // Brackets and commas in texts are none.
    assert!(parsed(&format!("{{\"a\":\"{}\"}}", "[,".repeat(MAX_VALUES))).is_ok());
}

#[test]
fn members_are_made_where_they_are_put() {
    let mut root = parsed(r#"{"a":5}"#).expect("sound");
    root["b"]["c"]["d"] = 1u32.into();
    root["a"]["e"] = "x".into();
    root.append("list", vec![true.into()]);
    root.append("list", vec![0.5.into()]);
    root.append("none", Vec::new());
    let text = r#"{"a":{"e":"x"},"b":{"c":{"d":1}},"list":[true,0.5]}"#;
    assert_eq!(root.to_string(), text);
}
