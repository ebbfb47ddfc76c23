//! Tables as people and their programs write them: a head, then one row per line, as CSV.
//!
//! Columns are separated by commas, by semicolons or by tabs: the head says which. Where it is not commas, numbers may have a decimal
//! comma, as spreadsheets write them in much of Europe; then a point, which would group thousands there, is refused. Lines that begin
//! with # and empty lines are left out, and every line keeps the number that it has in the file.

/// A line of a table.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Row {
    /// Line of the file, from 1.
    pub line: usize,
    /// One per column, without the spaces around it.
    pub fields: Vec<String>,
}

/// A head and rows with as many fields.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Table {
    /// Names of the columns.
    pub head: Row,
    /// In the order of the file.
    pub rows: Vec<Row>,
}

/// What is wrong with a table.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct TableProblem {
    /// Line of the file, from 1.
    pub line: usize,
    /// What, and what to write instead.
    pub message: String,
}

impl std::fmt::Display for TableProblem {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "line {}: {}", self.line, self.message)
    }
}

impl std::error::Error for TableProblem {}

impl Table {
    /// Splits a text into fields, with decimal points for decimal commas, and tells what is wrong: rows that have another number
    /// of fields than the head, which are left out, and numbers that can be read in two ways. What all rows have wrong is told once.
    #[must_use]
    pub fn parse(text: &str) -> (Self, Vec<TableProblem>) {
        let kept: Vec<(usize, &str)> = text
            .trim_start_matches('\u{feff}')
            .lines()
            .zip(1..)
            .filter(|(line, _)| !(line.trim().is_empty() || line.trim_start().starts_with('#')))
            .map(|(line, number)| (number, line))
            .collect();
        let head = kept.first().map_or("", |(_, text)| text);
        let separator = [b';', b'\t'].into_iter().find(|&s| head.contains(char::from(s))).unwrap_or(b',');
        let mut problems: Vec<TableProblem> = Vec::new();
        let mut rows = kept.iter().filter_map(|&(line, text)| match fields(text, separator) {
            Ok(fields) => Some(Row { line, fields }),
            Err(message) => {
                problems.push(TableProblem { line, message });
                None
            }
        });
        let head = rows.next().unwrap_or(Row { line: 1, fields: Vec::new() });
        let (even, uneven): (Vec<Row>, Vec<Row>) =
            rows.partition(|row| row.fields.len() == head.fields.len());
        if let Some(row) = uneven.first() {
            let message = wrong_count(row.fields.len(), &head, separator);
            problems.push(TableProblem { line: row.line, message });
        }
        let mut table = Self { head, rows: even };
        if separator != b',' {
            problems.extend(table.point_decimals());
        }
        (table, problems)
    }

    /// The place of a column.
    #[must_use]
    pub fn column(&self, name: &str) -> Option<usize> {
        self.head.fields.iter().position(|own| own == name)
    }

    /// Decimal points in place of decimal commas, and what is wrong where there are both.
    fn point_decimals(&mut self) -> Option<TableProblem> {
        let all = || self.rows.iter().flat_map(|row| row.fields.iter().map(move |field| (row.line, field)));
        let (line, sample) = all().find(|(_, f)| f.contains(',') && is_number(&f.replacen(',', ".", 1)))?;
        let point = all().find(|(_, f)| f.contains('.') && is_number(&f.replace([',', '.'], "")));
        let both = point.map(|(other, field)| TableProblem {
            line: other,
            message: format!(
                "{field} has a point, but line {line} has a decimal comma ({sample}): write one of both throughout, and no \
                 marks between thousands"
            ),
        });
        for field in self.rows.iter_mut().flat_map(|row| &mut row.fields) {
            let pointed = field.replacen(',', ".", 1);
            if is_number(&pointed) {
                *field = pointed;
            }
        }
        both
    }
}

fn is_number(field: &str) -> bool {
    field.parse::<f64>().is_ok()
}

fn fields(line: &str, separator: u8) -> Result<Vec<String>, String> {
    let mut reader = csv::ReaderBuilder::new()
        .has_headers(false)
        .delimiter(separator)
        .trim(csv::Trim::All)
        .from_reader(line.as_bytes());
    match reader.records().next() {
        Some(Ok(record)) => Ok(record.iter().map(str::to_owned).collect()),
        Some(Err(error)) => Err(format!("this is no row of a table: {error}")),
        None => Ok(Vec::new()),
    }
}

fn wrong_count(fields: usize, head: &Row, separator: u8) -> String {
    let counted = |n: usize| format!("{n} field{}", if n == 1 { "" } else { "s" });
    let (found, named) = (counted(fields), head.fields.len());
    let why = if separator == b',' && fields > named {
        "Commas separate columns in this table: write decimal points, or separate the columns with semicolons"
    } else {
        "Write one for each column, nothing between two separators where there is no value"
    };
    format!("{found} here, but line {} names {}. {why}", head.line, counted(named))
}

#[cfg(test)]
#[allow(clippy::panic)]
mod tests {
    use super::Table;

    fn rows(text: &str) -> Vec<(usize, Vec<String>)> {
        let (table, problems) = Table::parse(text);
        assert_eq!(problems, []);
        table.rows.into_iter().map(|row| (row.line, row.fields)).collect()
    }

    #[test]
    fn commas_semicolons_and_tabs_separate_the_same_table() {
        let expected = vec![
            (3, vec!["R1".to_string(), "-1.5".into(), String::new()]),
            (6, vec!["R2".into(), "2".into(), "3e-2".into()]),
        ];
        let text = "# measured, with care\nrobot;x_mm;y_mm\nR1;-1,5;\n\n# again\n R2 ; 2 ; 3e-2 \n";
        assert_eq!(rows(text), expected);
        assert_eq!(rows(&text.replace(';', "\t")), expected);
        assert_eq!(rows(&text.replace(',', ".").replace(';', ",")), expected);
        assert_eq!(rows(&format!("\u{feff}{}", text.replace('\n', "\r\n"))), expected);
        assert_eq!(Table::parse(text).0.column("y_mm"), Some(2));
    }

    #[test]
    fn what_can_be_read_in_two_ways_is_refused_once_with_its_line() {
        let says = |text: &str, line: usize, part: &str| {
            let (_, problems) = Table::parse(text);
            let [problem] = &problems[..] else { panic!("{problems:?}") };
            assert!(problem.line == line && problem.message.contains(part), "{problem}");
        };
        says("x_mm,y_mm\n# c\n1,5,2,5\n2,5,3,5\n", 3, "4 fields here, but line 1 names 2 fields");
        says("x_mm,y_mm\n1,5,2,5\n", 2, "write decimal points, or separate the columns with semicolons");
        says("x_mm;y_mm\n1\n", 2, "1 field here");
        says("x_mm;y_mm\n1,5;2\n1.234,5;2\n", 3, "1.234,5 has a point, but line 2 has a decimal comma (1,5)");
        says("x_mm;y_mm\n1,5;2\n1.5;2\n", 3, "write one of both throughout");
    }
}
