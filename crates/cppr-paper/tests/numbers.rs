//! Every page is computed again and compared with the numbers stored in `numbers.json`.
//!
//! After a wanted change: `cargo run --release -- paper --output report` and copy `report/numbers.json` here.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

use cppr_paper::{Page, html, pages};
use serde_json::Value;
use std::sync::LazyLock;

/// Every page, computed once for all tests.
static PAGES: LazyLock<Vec<Page>> = LazyLock::new(|| {
    std::thread::scope(|scope| {
        let running: Vec<_> =
            pages().into_iter().map(|job| scope.spawn(move || (job.name, job.run()))).collect();
        running
            .into_iter()
            .map(|page| page.join().unwrap())
            .map(|(name, page)| match page {
                Ok(page) => page,
                Err(error) => panic!("{name}: {error}"),
            })
            .collect()
    })
});

#[test]
fn pages_hold_the_stored_numbers_and_make_one_self_contained_file() {
    let stored: Value = serde_json::from_str(include_str!("numbers.json")).unwrap();
    let pages = &*PAGES;
    assert_eq!(pages.len(), stored.as_object().unwrap().len());
    let mut count = 0;
    for page in pages {
        let own = stored[&page.name].as_object().unwrap();
        assert_eq!(own.len(), page.numbers.len(), "{}: other numbers than stored", page.name);
        for (key, value) in &page.numbers {
            let want = own.get(key).and_then(Value::as_f64).unwrap_or_else(|| panic!("{}: {key}", page.name));
            // Searches step by 0.5 mm; everything else is an equilibrium, solved to eight digits or more.
            let tolerance = if key.ends_with("solved_to_mm") { 0.51 } else { 1e-5 + 1e-5 * want.abs() };
            assert!((value - want).abs() < tolerance, "{}: {key} is {value}, stored is {want}", page.name);
            count += 1;
        }
        for table in &page.tables {
            assert!(
                table.rows.iter().all(|row| row.len() == table.head.len()),
                "{}: ragged table",
                page.name
            );
        }
    }
    assert!(count > 1000, "{count}");
    let report = html(pages).unwrap();
    // No page of the network is needed: the only addresses are XML name spaces.
    for (at, _) in report.match_indices("http") {
        assert!(report[at..].starts_with("http://www.w3.org/"), "{}", &report[at..at + 60]);
    }
    assert!(report.matches("<svg").count() >= 25 && !report.contains("<script"));
}

/// What the report claims, as inequalities that a wrong sign or a lost term breaks.
#[test]
fn the_claims_of_the_report_hold() {
    let page = |name: &str| PAGES.iter().find(|page| page.name == name).unwrap();
    let differences = page("differences");
    let number = |page: &Page, key: &str| {
        page.numbers.iter().find(|(k, _)| k == key).unwrap_or_else(|| panic!("{key}")).1
    };
    for (key, value) in &differences.numbers {
        if key.ends_with("consistent_off_percent") {
            assert!(*value < 0.01, "{key}: {value} % of L from the brute force");
        }
        if key.ends_with("printed_off_percent") {
            assert!(*value > 1.0, "{key}: {value} %");
        }
    }
    let best = number(differences, "all/best_factor");
    assert!((1.25..1.28).contains(&best), "{best}");
    for name in ["r1", "r2", "r3", "r4"] {
        let own = number(differences, &format!("{name}/best_factor"));
        assert!((1.20..1.29).contains(&own), "{name}: {own}");
    }
    for name in ["r3", "r4"] {
        for side in ["pulled", "pushed"] {
            let reached = number(differences, &format!("{name}/consistent/{side}/solved_to_mm"));
            assert!(reached.abs() > 19.9, "{name} {side} {reached}");
        }
    }
    assert!(number(differences, "r3/printed/pulled/solved_to_mm") < 15.0);
    // The printed formula leaves no bending stiffness at R4's tip beyond 10 to 11 mm.
    let left = |pull: &str| number(differences, &format!("r4/{pull}/printed_stiffness_left"));
    assert!(left("10mm") > 0.01 && left("12mm") < -0.01);
    // Uniform robots have the same tension everywhere in the printed formula too; tapered ones do not.
    let share = |key: &str| number(differences, &format!("{key}/printed_tension_share_tip"));
    assert!((share("r1/7mm") - 1.0).abs() < 1e-4 && (share("r4/11mm") - 1.0).abs() > 0.3);
    let depth = number(page("depth"), "factor 1.27/both tubes/largest_change_mm");
    assert!((depth - 3.93).abs() < 0.01, "{depth}");
    let free = page("figure14");
    assert!(number(free, "r4/+11mm/consistent/tip_y_mm") < -60.0);
    assert!(number(free, "r4/-11mm/consistent/tip_y_mm") > 60.0);
}
