//! Tables for people: aligned columns of text, and the tables of the passes of a frame.

use crate::failure::shown;
use manypass::Plan;
use manypass::graph::{PassTime, PassWork, PlannedAttachment, PlannedPass, Target};
use std::borrow::Cow;

/// The longest line, in characters.
const LINE_CHARACTERS: usize = 100;
/// What stands between two columns.
const GAP: &str = "  ";
/// A column of names is never narrower for the sake of the line.
const NAME_CHARACTERS: usize = 12;
/// A megabyte, as disks and buses count it.
const MB_BYTES: f64 = 1e6;

/// How a column is set.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Column {
    /// From the left. Its cells are cut in the middle where the line would be too long.
    Name,
    /// From the left, never cut.
    Word,
    /// From the right, never cut.
    Number,
}

/// What the passes of a frame took, drew and moved, in their order, with their sum. Milliseconds are those of the GPU
/// where the adapter has timestamps, else those of recording, which the last line says. Empty without passes.
pub fn of_times(times: &[PassTime], work: &[PassWork]) -> String {
    if times.is_empty() {
        return String::new();
    }
    let is_of_gpu = times.iter().any(|time| time.gpu_ms.is_some());
    let ms_of = |time: &PassTime| if is_of_gpu { time.gpu_ms } else { Some(time.cpu_ms) };
    let sum_ms: f64 = times.iter().filter_map(ms_of).sum();
    let share = |ms: f64| if sum_ms > 0.0 { 100.0 * ms / sum_ms } else { 0.0 };
    let ms_title = if is_of_gpu { "GPU ms" } else { "CPU ms" };
    let mut rows = vec![["pass", ms_title, "share %", "draws", "read MB", "written MB"].map(str::to_owned)];
    let (mut draws, mut read_bytes, mut written_bytes) = (0_u64, 0_u64, 0_u64);
    for time in times {
        let done = work.iter().find(|done| done.name == time.name);
        draws += u64::from(done.and_then(|done| done.draws).unwrap_or(0));
        read_bytes += done.map_or(0, |done| done.read);
        written_bytes += done.map_or(0, |done| done.written);
        rows.push([
            time.name.clone(),
            number(ms_of(time), 2),
            number(ms_of(time).map(share), 1),
            number(done.and_then(|done| done.draws).map(f64::from), 0),
            megabytes(done.map(|done| done.read)),
            megabytes(done.map(|done| done.written)),
        ]);
    }
    rows.push([
        "sum".to_owned(),
        number(Some(sum_ms), 2),
        number(Some(share(sum_ms)), 1),
        draws.to_string(),
        megabytes(Some(read_bytes)),
        megabytes(Some(written_bytes)),
    ]);
    let [name, number] = [Column::Name, Column::Number];
    let mut text = table([name, number, number, number, number, number], &rows);
    if !is_of_gpu {
        text.push_str("CPU ms is the time to record a pass, not to execute it: the adapter has no timestamps\n");
    }
    text
}

/// The passes of a plan in their order, each target on a line of its own, with their sum and the memory of textures.
pub fn of_plan(plan: &Plan) -> String {
    let titles = ["pass", "kind", "writes", "format", "size", "draws", "read MB", "written MB"];
    let mut rows = vec![titles.map(str::to_owned)];
    for (pass, work) in plan.passes.iter().zip(plan.pass_work()) {
        let mut targets = targets(plan, pass).into_iter();
        let [name, format, size] = targets.next().unwrap_or_default();
        let draws = number(work.draws.map(f64::from), 0);
        let (read, written) = (megabytes(Some(work.read)), megabytes(Some(work.written)));
        rows.push([pass.name.to_string(), kind(pass).to_owned(), name, format, size, draws, read, written]);
        let none = String::new;
        rows.extend(targets.map(|[name, format, size]| [none(), none(), name, format, size, none(), none(), none()]));
    }
    let none = String::new;
    let draws: u64 = plan.passes.iter().filter_map(|pass| pass.draws).map(u64::from).sum();
    let (read, written) = (megabytes(Some(plan.read_bytes())), megabytes(Some(plan.written_bytes())));
    rows.push(["sum".to_owned(), none(), none(), none(), none(), draws.to_string(), read, written]);
    let [name, word, number] = [Column::Name, Column::Word, Column::Number];
    let columns = [name, word, name, word, word, number, number, number];
    let bytes = plan.bytes();
    let [aliased, unaliased, imported, memoryless] =
        [bytes.aliased, bytes.unaliased, bytes.imported, bytes.memoryless].map(|bytes| megabytes(Some(bytes)));
    format!(
        "{}{} passes in {} render passes, {} culled\n\
         textures: {aliased} MB, {unaliased} MB if none shared memory, {imported} MB imported\n\
         {memoryless} MB of the {aliased} MB need no memory on GPUs that draw tile by tile (docs/targets.md)\n",
        table(columns, &rows),
        plan.passes.len(),
        plan.render_passes,
        plan.culled.len(),
    )
}

/// Name, format and size of all that a pass writes.
fn targets(plan: &Plan, pass: &PlannedPass) -> Vec<[String; 3]> {
    let written = pass.attachments.iter().filter(|attachment| attachment.target != Target::DepthReadOnly);
    let target = |attachment: &PlannedAttachment| {
        let texture = plan.textures.get(attachment.texture as usize)?;
        let mut name = texture.name.to_string();
        for (index, count, part) in
            [(attachment.mip, texture.desc.mips, "mip"), (attachment.layer, texture.desc.layers, "layer")]
        {
            if count > 1 {
                name.push_str(&format!(" {part} {index}"));
            }
        }
        let (width, height) = pass.size;
        Some([name, format!("{:?}", texture.desc.format), format!("{width}x{height}")])
    };
    written.filter_map(target).collect()
}

/// What a pass is attached to, colours or depth or both, be it written or tested alone.
fn kind(pass: &PlannedPass) -> &'static str {
    let is_color = |attachment: &PlannedAttachment| matches!(attachment.target, Target::Color(_) | Target::Resolve(_));
    let has_color = pass.attachments.iter().any(is_color);
    let has_depth = pass.attachments.iter().any(|attachment| !is_color(attachment));
    match (has_color, has_depth) {
        (true, true) => "both",
        (true, false) => "color",
        (false, true) => "depth",
        (false, false) => "-",
    }
}

/// A number with so many decimals; a dash for one that nobody knows.
fn number(value: Option<f64>, decimals: usize) -> String {
    value.map_or_else(|| "-".to_owned(), |value| format!("{value:.decimals$}"))
}

/// Bytes as megabytes; a dash for those that nobody knows.
fn megabytes(bytes: Option<u64>) -> String {
    number(bytes.map(|bytes| bytes as f64 / MB_BYTES), 2)
}

/// Rows, of which the first has the titles, as lines of aligned cells.
fn table<const N: usize>(columns: [Column; N], rows: &[[String; N]]) -> String {
    let printed = |cell: String| shown(&cell.replace(['\n', '\t'], " ")).into_owned();
    let rows: Vec<[String; N]> = rows.iter().map(|row| row.clone().map(printed)).collect();
    let width = |column: usize| rows.iter().map(|row| row[column].chars().count()).max().unwrap_or(0);
    let widths = narrowed(columns, std::array::from_fn(width));
    let mut text = String::new();
    for row in &rows {
        let mut line = String::new();
        for ((column, &width), cell) in columns.iter().zip(&widths).zip(row) {
            let cell = cut(cell, width);
            let set = match column {
                Column::Name | Column::Word => format!("{cell:<width$}{GAP}"),
                Column::Number => format!("{cell:>width$}{GAP}"),
            };
            line.push_str(&set);
        }
        text.push_str(line.trim_end());
        text.push('\n');
    }
    text
}

/// The widths of columns that fit into a line, as long as the names have room to give: the widest gives first.
fn narrowed<const N: usize>(columns: [Column; N], mut widths: [usize; N]) -> [usize; N] {
    let most = LINE_CHARACTERS.saturating_sub(GAP.len() * N.saturating_sub(1));
    while widths.iter().sum::<usize>() > most {
        let names = columns.iter().zip(widths.iter_mut()).filter(|(column, _)| **column == Column::Name);
        match names.map(|(_, width)| width).filter(|width| **width > NAME_CHARACTERS).max() {
            Some(width) => *width -= 1,
            None => break,
        }
    }
    widths
}

/// A text of at most `width` characters: of a longer one its beginning and its end, with `…` between.
fn cut(text: &str, width: usize) -> Cow<'_, str> {
    let count = text.chars().count();
    if count <= width {
        return Cow::Borrowed(text);
    }
    let kept = width.saturating_sub(1);
    let tail = kept / 2;
    let (head, end) = (text.chars().take(kept - tail), text.chars().skip(count - tail));
    Cow::Owned(head.chain(std::iter::once('…')).chain(end).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn time(name: &str, cpu_ms: f64, gpu_ms: Option<f64>) -> PassTime {
        PassTime { name: name.to_owned(), cpu_ms, gpu_ms }
    }

    fn done(name: &'static str, draws: Option<u32>, read: u64, written: u64) -> PassWork {
        PassWork { name: name.into(), draws, read, written }
    }

    #[test]
    fn columns_are_aligned_and_the_last_line_is_the_sum() {
        let times = [
            time("geometry", 0.1, Some(1.5)),
            time("lighting.clustered", 0.2, Some(4.5)),
            // Beyond the queries of a set there are no times, and of other frames' passes no bytes.
            time("gone", 0.3, None),
            // Who declares a pass may leave its draws uncounted.
            time("own", 0.0, Some(0.0)),
        ];
        let work = [
            done("geometry", Some(1200), 0, 14_745_600),
            done("lighting.clustered", Some(1), 14_745_600, 7_372_800),
            done("own", None, 0, 0),
        ];
        let expected = "\
pass                GPU ms  share %  draws  read MB  written MB
geometry              1.50     25.0   1200     0.00       14.75
lighting.clustered    4.50     75.0      1    14.75        7.37
gone                     -        -      -        -           -
own                   0.00      0.0      -     0.00        0.00
sum                   6.00    100.0   1201    14.75       22.12
";
        assert_eq!(of_times(&times, &work), expected);
        assert_eq!(of_times(&[], &work), "");
    }

    #[test]
    fn without_timestamps_the_table_says_where_its_times_come_from() {
        let text = of_times(&[time("a", 0.25, None), time("b", 0.75, None)], &[]);
        let lines: Vec<&str> = text.lines().collect();
        assert!(lines[0].contains("CPU ms") && !text.contains("GPU ms"), "{text}");
        assert_eq!(lines[1].split_whitespace().collect::<Vec<_>>(), ["a", "0.25", "25.0", "-", "-", "-"]);
        assert_eq!(lines[3].split_whitespace().collect::<Vec<_>>(), ["sum", "1.00", "100.0", "0", "0.00", "0.00"]);
        assert!(lines[4].contains("the adapter has no timestamps") && lines[4].len() <= LINE_CHARACTERS, "{text}");
        // Nothing is divided by nothing.
        assert!(of_times(&[time("a", 0.0, None)], &[]).contains(" 0.0 "));
    }

    #[test]
    fn long_names_are_cut_in_the_middle() {
        let name = format!("{}{}", "a".repeat(150), "z".repeat(150));
        let text = of_times(&[time(&name, 0.1, Some(1.0)), time("short", 0.1, Some(3.0))], &[]);
        assert!(text.lines().all(|line| line.chars().count() <= LINE_CHARACTERS), "{text}");
        assert!(text.lines().any(|line| line.starts_with("aaa") && line.contains("a…z")), "{text}");
        let [name, title] = [1, 0].map(|line| text.lines().nth(line).unwrap_or_default().chars().count());
        assert_eq!(name, title, "numbers stand below each other: {text}");
        assert_eq!(
            (cut("abcdef", 6), cut("abcdef", 5), cut("äöüßé", 4)),
            ("abcdef".into(), "ab…ef".into(), "äö…é".into())
        );
        assert_eq!((cut("abcdef", 1), cut("", 0)), ("…".into(), "".into()));
    }

    #[test]
    fn the_wider_of_two_names_gives_and_words_stay() {
        let columns = [Column::Name, Column::Word, Column::Name];
        assert_eq!(narrowed(columns, [30, 20, 40]), [30, 20, 40]);
        assert_eq!(narrowed(columns, [20, 20, 90]), [20, 20, 56]);
        assert_eq!(narrowed(columns, [90, 20, 90]).iter().sum::<usize>(), 96);
        assert_eq!(narrowed(columns, [90, 120, 90]), [NAME_CHARACTERS, 120, NAME_CHARACTERS]);
    }

    #[test]
    fn cells_hold_no_commands_to_a_terminal() {
        let text = table([Column::Name, Column::Word], &[["a\u{1b}[2J\nb".to_owned(), "c".to_owned()]]);
        assert_eq!(text, "a\\u001b[2J b  c\n");
    }
}
