//! Tables as text, row by row as they are measured, and as markdown at the end.

/// A column: its heading and how many characters it has at least.
pub(crate) type Column<'a> = (&'a str, usize);

#[derive(Debug, Default)]
struct Table {
    title: String,
    headings: Vec<String>,
    widths: Vec<usize>,
    rows: Vec<Vec<String>>,
    notes: Vec<String>,
}

/// All tables of a run.
#[derive(Debug, Default)]
pub(crate) struct Report {
    tables: Vec<Table>,
}

impl Report {
    /// Begins a table and prints its head.
    pub fn begin(&mut self, title: &str, columns: &[Column]) {
        let headings: Vec<String> = columns.iter().map(|(heading, _)| (*heading).to_owned()).collect();
        let widths = columns.iter().map(|(heading, width)| heading.chars().count().max(*width)).collect();
        let table = Table { title: title.to_owned(), headings, widths, ..Table::default() };
        println!("\n{title}:\n{}", line(&table.headings, &table.widths));
        self.tables.push(table);
    }

    /// Adds a row to the table that was begun last, and prints it.
    pub fn row(&mut self, cells: Vec<String>) {
        if let Some(table) = self.tables.last_mut() {
            println!("{}", line(&cells, &table.widths));
            table.rows.push(cells);
        }
    }

    /// Adds a sentence below the table that was begun last, and prints it.
    pub fn note(&mut self, sentence: &str) {
        println!("{sentence}");
        if let Some(table) = self.tables.last_mut() {
            table.notes.push(sentence.to_owned());
        }
    }

    /// All tables as markdown, after a sentence that says what measured them, and where.
    pub fn markdown(&self, measured_by: &str) -> String {
        let mut text = format!("{measured_by}\n");
        for table in &self.tables {
            let rule = table.headings.iter().enumerate().map(|(at, _)| if at == 0 { "---" } else { "---:" });
            text += &format!("\n### {}\n\n{}", table.title, markdown_row(table.headings.iter()));
            text += &markdown_row(rule);
            for row in &table.rows {
                text += &markdown_row(row.iter());
            }
            for note in &table.notes {
                text += &format!("\n{note}\n");
            }
        }
        text
    }
}

/// Cells below each other: the first to the left, the others to the right.
fn line(cells: &[String], widths: &[usize]) -> String {
    let mut line = String::new();
    for (at, (cell, &width)) in cells.iter().zip(widths).enumerate() {
        line += &if at == 0 { format!("{cell:width$}") } else { format!(" {cell:>width$}") };
    }
    line.trim_end().to_owned()
}

fn markdown_row(cells: impl Iterator<Item = impl AsRef<str>>) -> String {
    let cells: Vec<String> = cells.map(|cell| cell.as_ref().replace('|', "\\|")).collect();
    format!("| {} |\n", cells.join(" | "))
}

/// Milliseconds with three digits.
pub(crate) fn milliseconds(ms: f64) -> String {
    match ms {
        ms if !ms.is_finite() => "-".to_owned(),
        ms if ms < 10.0 => format!("{ms:.2}"),
        ms if ms < 100.0 => format!("{ms:.1}"),
        ms => format!("{ms:.0}"),
    }
}

/// A ratio with two digits behind the point, or none if it is not known.
pub(crate) fn ratio(value: f64) -> String {
    match value {
        value if !value.is_finite() => "-".to_owned(),
        value if value < 100.0 => format!("{value:.2}"),
        value => format!("{value:.0}"),
    }
}

/// The middle one of some numbers, or the mean of both.
pub(crate) fn median(mut numbers: Vec<f64>) -> Option<f64> {
    numbers.sort_by(f64::total_cmp);
    let middle = numbers.len() / 2;
    let upper = *numbers.get(middle)?;
    Some(if numbers.len() % 2 == 1 { upper } else { 0.5 * (upper + numbers.get(middle - 1)?) })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_report_is_markdown() {
        let mut report = Report::default();
        report.begin("Lights", &[("scene", 4), ("ms", 6)]);
        report.row(vec!["a|b".into(), milliseconds(12.34)]);
        report.note("A sentence.");
        assert_eq!(
            report.markdown("Measured by somebody."),
            "Measured by somebody.\n\n### Lights\n\n\
             | scene | ms |\n| --- | ---: |\n| a\\|b | 12.3 |\n\nA sentence.\n"
        );
    }

    #[test]
    fn cells_stand_below_each_other() {
        let cells = |first: &str, second: &str| [first.to_owned(), second.to_owned()];
        assert_eq!(line(&cells("scene", "ms"), &[7, 5]), "scene      ms");
        assert_eq!(line(&cells("a", "12.3"), &[7, 5]), "a        12.3");
    }

    #[test]
    fn medians_do_not_depend_on_the_order() {
        assert_eq!(median(vec![]), None);
        assert_eq!(median(vec![3.0, 1.0, 2.0]), Some(2.0));
        assert_eq!(median(vec![4.0, 1.0, 2.0, 3.0]), Some(2.5));
    }

    #[test]
    fn numbers_have_about_three_digits() {
        assert_eq!([1.2345, 12.345, 123.45, f64::NAN].map(milliseconds), ["1.23", "12.3", "123", "-"]);
        assert_eq!([1.2345, 123.45, f64::INFINITY].map(ratio), ["1.23", "123", "-"]);
    }
}
