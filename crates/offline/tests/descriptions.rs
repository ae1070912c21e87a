//! The descriptions of settings, stage keys, uniforms and AOVs are short sentences in the field's terms. Help, tables and
//! schemas consist of them.

use manypass::{Aov, EffectFile, Settings, SimulationFile};
use manypass_scene::simulation::Program;
use manypass_scene::stage::keys::TABLES;
use manypass_testkit::sentences;

/// The faults of all descriptions, and how many descriptions there are.
fn faults(descriptions: impl Iterator<Item = (String, String)>) -> (Vec<String>, usize) {
    let (mut found, mut count) = (Vec::new(), 0);
    for (key, text) in descriptions {
        count += 1;
        // The names of all demos are no sentence.
        let text = text.split("; or demo:").next().unwrap_or_default();
        for sentence in sentences::of_text(text) {
            found.extend(sentence.fault().map(|fault| format!("{key}: {fault}: {}", sentence.text)));
        }
    }
    (found, count)
}

fn assert_plain(descriptions: impl Iterator<Item = (String, String)>, least: usize) {
    let (found, count) = faults(descriptions);
    assert!(count >= least, "{count} descriptions");
    assert!(found.is_empty(), "{}", found.join("\n"));
}

#[test]
fn descriptions_of_settings_are_plain() {
    assert_plain(Settings::declared().iter().map(|info| (info.key.to_string(), info.doc.to_string())), 100);
}

#[test]
fn descriptions_of_stage_keys_are_plain() {
    let of_keys = TABLES
        .iter()
        .flat_map(|table| table.keys.iter().map(|key| (format!("{}.{}", table.name, key.name), key.doc.to_owned())));
    assert_plain(of_keys.chain(TABLES.iter().map(|table| (table.name.into(), table.doc.into()))), 150);
}

#[test]
fn descriptions_of_uniforms_are_plain() {
    let effects = EffectFile::built_in_names()
        .flat_map(|name| EffectFile::built_in(name).expect("built in").expect("a valid effect").settings().to_vec());
    let simulations = SimulationFile::built_in_names().flat_map(|name| {
        SimulationFile::of_program(&Program::BuiltIn(name.into())).expect("a valid program").parameters().to_vec()
    });
    assert_plain(effects.chain(simulations).map(|info| (info.key.to_string(), info.doc.to_string())), 80);
}

#[test]
fn descriptions_of_aovs_are_plain() {
    assert_plain(Aov::ALL.iter().map(|aov| (aov.name().into(), aov.info().doc.into())), 14);
}

#[test]
fn a_long_sentence_and_a_riddle_are_found() {
    let long = "one ".repeat(26);
    let texts =
        [("long", long.as_str()), ("riddle", "A plane that is seen by the shadow on it alone."), ("plain", "Short.")];
    let (found, count) = faults(texts.into_iter().map(|(key, text)| (key.to_owned(), text.to_owned())));
    assert_eq!((found.len(), count), (2, 3), "{found:?}");
    assert!(found[0].starts_with("long: 26 words") && found[1].contains("shadow catcher"), "{found:?}");
}
