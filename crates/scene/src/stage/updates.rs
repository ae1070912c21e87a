//! When pictures of a stage are drawn anew.

use super::table::{Table, whole};
use super::words::UPDATES;
use crate::Diagnostic;
use crate::capture::Update;

/// When something is drawn anew, by the keys `update` and `every`.
///
/// # Errors
/// The two do not go together.
pub(super) fn update_of(table: &Table<'_>) -> Result<Update, Box<Diagnostic>> {
    let every = table.number("every").map(|every| whole(table, "every", every)).transpose()?;
    let update = match (table.text("update").map(|word| word.value == UPDATES[1]), every) {
        (Some(true), Some(_)) => {
            return Err(table.fault("every", "`every` does not go with `update = \"once\"`"));
        }
        (Some(true), None) => Update::Once,
        (_, Some(frames)) if frames > 1 => Update::Every(frames),
        _ => Update::Always,
    };
    Ok(update)
}
