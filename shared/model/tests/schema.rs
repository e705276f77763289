//! The JSON Schema describes what is read.

use serde_json::Value;

fn schema() -> Value {
    model::problem_schema().to_value()
}

#[test]
fn the_schema_is_as_published() {
    let text = serde_json::to_string_pretty(&schema()).unwrap();
    insta::with_settings!({omit_expression => true}, { insta::assert_snapshot!(text) });
}

#[test]
fn no_object_of_the_schema_lets_unknown_keys_pass() {
    let schema = schema();
    let definitions = schema["$defs"].as_object().unwrap();
    let open: Vec<&String> = definitions
        .iter()
        .filter(|(_, value)| value.get("properties").is_some() && value["additionalProperties"] != Value::Bool(false))
        .map(|(name, _)| name)
        .collect();
    assert!(open.is_empty(), "{open:?}");
    assert_eq!(schema["additionalProperties"], Value::Bool(false));
}
