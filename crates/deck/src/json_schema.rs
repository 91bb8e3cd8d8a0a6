//! The deck's keys as a JSON Schema, from what the parser itself uses: editors complete and check decks with it.

use crate::decoder::ReadKeys;
use crate::document::{joined, value};
use crate::schema::{End, KeySchema, Presence, QuantitySchema, Schema, TableSchema};
use crate::units::Dimension;
use serde_json::{Map, Value, json};

/// The schema of the deck of a simulation.
pub fn of_deck() -> Value {
    document("Deck of an Estar simulation", &super::Deck::keys())
}

/// The schema of the deck of a material point.
pub fn of_point_deck() -> Value {
    document("Deck of an Estar material point", &super::point::PointDeck::keys())
}

fn document(title: &str, keys: &TableSchema) -> Value {
    let mut schema = table(keys);
    schema.insert("$schema".to_owned(), json!("http://json-schema.org/draft-07/schema#"));
    schema.insert("title".to_owned(), json!(title));
    Value::Object(schema)
}

/// A table whose keys depend on another has them all, so that an editor knows them, and conditions that leave those of the
/// chosen case.
fn table(table: &TableSchema) -> Map<String, Value> {
    let mut properties: Map<String, Value> = table.keys.iter().map(property).collect();
    let mut required: Vec<&str> = names_of_required(&table.keys);
    let mut conditions = Vec::new();
    for variants in &table.variants {
        required.extend(variants.default.is_none().then_some(variants.tag));
        let names = variants.cases.iter().map(|(choice, _)| choice.name);
        let meanings = variants.cases.iter().map(|(choice, _)| format!("\"{}\": {}", choice.name, joined(choice.doc)));
        let description = format!("{} {}", joined(variants.doc), meanings.collect::<Vec<_>>().join(" "));
        let tag = json!({ "enum": names.collect::<Vec<_>>(), "description": description });
        properties.insert(variants.tag.to_owned(), tag);

        let own = |keys: &[KeySchema]| keys.iter().map(property).collect::<Map<_, _>>();
        let mut meant: Map<String, Value> = Map::new();
        for (name, schema) in variants.cases.iter().flat_map(|(_, keys)| own(keys)) {
            let known = meant.entry(name).or_insert_with(|| json!({ "anyOf": [] }));
            if let Some(known) = known["anyOf"].as_array_mut().filter(|known| !known.contains(&schema)) {
                known.push(schema);
            }
        }
        for (choice, keys) in &variants.cases {
            // what all cases mean by a key stands above
            let mut properties = own(keys);
            properties.retain(|name, _| meant[name.as_str()]["anyOf"].as_array().is_some_and(|known| known.len() > 1));
            for foreign in meant.keys().filter(|name| !keys.iter().any(|key| key.name == name.as_str())) {
                properties.insert(foreign.clone(), json!(false));
            }
            // a tag that is not there meets any condition on its value
            let needed: &[&str] = if variants.default == Some(choice.name) { &[] } else { &[variants.tag] };
            conditions.push(json!({
                "if": { "properties": { variants.tag: { "const": choice.name } }, "required": needed },
                "then": { "properties": properties, "required": names_of_required(keys) },
            }));
        }
        properties.extend(meant.into_iter().map(|(name, mut known)| match known["anyOf"].as_array_mut() {
            Some(only) if only.len() == 1 => (name, only.swap_remove(0)),
            _ => (name, known),
        }));
    }
    let mut schema = Map::new();
    schema.insert("type".to_owned(), json!("object"));
    schema.insert("description".to_owned(), json!(joined(table.doc)));
    schema.insert("properties".to_owned(), Value::Object(properties));
    schema.insert("required".to_owned(), json!(required));
    schema.insert("additionalProperties".to_owned(), json!(false));
    if !conditions.is_empty() {
        schema.insert("allOf".to_owned(), json!(conditions));
    }
    schema
}

fn names_of_required(keys: &[KeySchema]) -> Vec<&'static str> {
    keys.iter().filter(|key| key.presence == Presence::Required).map(|key| key.name).collect()
}

fn property(key: &KeySchema) -> (String, Value) {
    let mut schema = of_value(&key.value);
    let words = match &key.value {
        Schema::Table(_) | Schema::Named(_) => String::new(),
        Schema::List(inner) if matches!(**inner, Schema::Table(_)) => String::new(),
        other => format!(" ({})", value(other).replace('`', "")),
    };
    schema.insert("description".to_owned(), json!(format!("{}{words}", joined(key.doc))));
    if let Some(default) = default_of(key.presence) {
        schema.insert("default".to_owned(), default);
    }
    (key.name.to_owned(), Value::Object(schema))
}

/// The default, which is written as in a deck.
fn default_of(presence: Presence) -> Option<Value> {
    let Presence::Default(text) = presence else { return None };
    let mut table: toml::Table = format!("default = {text}").parse().ok()?;
    serde_json::to_value(table.remove("default")?).ok()
}

fn of_value(schema: &Schema) -> Map<String, Value> {
    let json = match schema {
        Schema::Text(_) | Schema::Group(_) => json!({ "type": "string" }),
        Schema::Count => json!({ "type": "integer", "minimum": 1 }),
        Schema::Quantity(quantity) => of_quantity(quantity),
        Schema::Vector(quantity, count) => list(of_quantity(quantity), Some(*count)),
        Schema::Direction => row(3),
        Schema::Rows(_, count) => list(row(*count), None),
        Schema::Points(x, y) => {
            let pair =
                json!({ "type": "array", "items": [of_quantity(x), of_quantity(y)], "minItems": 2, "maxItems": 2 });
            list(pair, None)
        }
        Schema::Choice(choices) => json!({ "enum": choices.iter().map(|choice| choice.name).collect::<Vec<_>>() }),
        Schema::Table(inner) => Value::Object(table(inner)),
        Schema::List(inner) => list(Value::Object(of_value(inner)), None),
        Schema::Named(inner) => json!({ "type": "object", "additionalProperties": of_value(inner) }),
        Schema::Either(schemas) => json!({ "anyOf": schemas.iter().map(of_value).collect::<Vec<_>>() }),
    };
    match json {
        Value::Object(map) => map,
        _ => Map::new(),
    }
}

/// A list of so many numbers, or strings with a unit.
fn row(count: usize) -> Value {
    list(json!({ "type": ["number", "string"] }), Some(count))
}

fn list(items: Value, length: Option<usize>) -> Value {
    match length {
        Some(length) => json!({ "type": "array", "items": items, "minItems": length, "maxItems": length }),
        None => json!({ "type": "array", "items": items }),
    }
}

/// A number in SI units, or a string with a unit, which only the parser can check.
fn of_quantity(quantity: &QuantitySchema) -> Value {
    let mut number = Map::from_iter([("type".to_owned(), json!("number"))]);
    let mut end = |end: Option<End>, included: &str, excluded: &str| match end {
        Some(End::Included(value)) => number.insert(included.to_owned(), json!(value)),
        Some(End::Excluded(value)) => number.insert(excluded.to_owned(), json!(value)),
        None => None,
    };
    end(quantity.interval.low, "minimum", "exclusiveMinimum");
    end(quantity.interval.high, "maximum", "exclusiveMaximum");
    if quantity.is_angle {
        // any other plain number could be degrees
        number.insert("const".to_owned(), json!(0));
    }
    // a pure number may be written as one with a unit too, such as a percentage
    let unit = match quantity.dimension {
        Some(dimension) if dimension != Dimension::NUMBER => {
            format!("a number with a unit, such as {}", dimension.si_unit())
        }
        _ => "a number with a unit".to_owned(),
    };
    json!({ "anyOf": [number, { "type": "string", "description": unit }] })
}
