//! `[tube.notches]`: the pattern that is cut into a tube.
//!
//! The cells of the pattern, a notch in the middle and half a tooth on either side, follow one another
//! from the baseplate on. One value per notch holds at the middle of the notch.

use crate::cursor::Cursor;
use crate::problems::Collector;
use crate::profile_value::{Direction, Number, Spread, Written, read};
use crate::quantity::{DEPTH, LEAST_WALL, LENGTH, STIFFNESS, print, print_mm};
use crate::robot_file::NotchPattern;
use crate::teeth::{Teeth, read_teeth};
use cppr::design::{BelowPlate, Outline, Profile, Torsion};
use toml::de::DeValue;

const KEYS: [&str; 13] = [
    "depth_mm",
    "length_mm",
    "tooth_mm",
    "count",
    "opening_deg",
    "twist_deg",
    "torsion",
    "below_plate",
    "teeth",
    "cut",
    "corner_radius_mm",
    "tooth_factor",
    "contact",
];
/// Most notches of a tube.
const MOST: u32 = 10_000;
/// Abscissae at which the depth of an interpolated pattern is looked at.
const SAMPLES: u16 = 512;
/// A depth below 0 by less (m) is 0 but for rounding.
const NO_DEPTH: f64 = 1e-12;
/// Share of a cell by which a pattern may outgrow the tube through rounding of decimal numbers.
const ROUNDING: f64 = 1e-9;

/// What the table says.
pub(crate) struct Notches {
    pub depth: Profile,
    pub direction: Profile,
    pub torsion: Torsion,
    pub below: BelowPlate,
    pub pattern: Option<NotchPattern>,
    pub teeth: Teeth,
    pub contact: bool,
}

/// Reads the notches of tube `tube` (from 1). `length` (m) and `outline` may be unknown after a problem.
pub(crate) fn read_notches(
    parent: &Cursor<'_, '_>,
    tube: usize,
    length: Option<f64>,
    outline: Option<&Outline>,
    out: &mut Collector,
) -> Option<Notches> {
    let cursor = parent.child("notches", &KEYS, out)?;
    let depth = cursor
        .require("depth_mm", "Write depth_mm = 5.0, or leave notches out for an uncut tube.", out)
        .and_then(|entry| read(&entry, &DEPTH, true, length, out));
    let direction = Direction::read(&cursor, tube, true, length, out);
    let lists: Vec<&Written> = depth
        .iter()
        .chain(direction.opening())
        .filter(|written| written.spread == Spread::PerNotch)
        .collect();
    let pattern = read_pattern(&cursor, &lists, length, out);
    let middles = pattern.as_ref().map(NotchPattern::middles).unwrap_or_default();
    let torsion = read_torsion(&cursor, length, out);
    let teeth = read_teeth(&cursor, pattern.is_some(), out);
    let contact = read_contact(&cursor, out);
    let below = match cursor.get("below_plate").map(|entry| entry.word(&["plain", "continued"], out)) {
        Some(Some("continued")) => BelowPlate::Continued,
        _ => BelowPlate::Plain,
    };
    // A list of the wrong count has its own problem, and no curve goes through it.
    let fits = lists.iter().all(|list| list.numbers.len() == middles.len());
    let depth = depth.filter(|_| fits).and_then(|written| {
        let sound = outline.is_none_or(|outline| check_depths(&written, outline, out));
        let profile = written.build(|value| value, &middles, out)?;
        if let (true, Some(outline), Some(length)) = (sound, outline, length) {
            check_curve(&written, &profile, outline, length, out);
        }
        Some(profile)
    });
    let direction = if fits { direction.build(&middles, out) } else { None };
    Some(Notches {
        depth: depth?,
        direction: direction?,
        torsion: torsion?,
        below,
        pattern,
        teeth: teeth?,
        contact: contact?,
    })
}

/// Do teeth that meet carry load?
fn read_contact(cursor: &Cursor<'_, '_>, out: &mut Collector) -> Option<bool> {
    let Some(entry) = cursor.get("contact") else { return Some(false) };
    let DeValue::Boolean(contact) = entry.value else {
        entry.wrong(
            "this is neither true nor false",
            "Write contact = true: teeth that meet carry load.",
            out,
        );
        return None;
    };
    if *contact && !(cursor.has("length_mm") && cursor.has("tooth_mm")) {
        let message = "where teeth meet follows from the lengths of notch and tooth";
        out.missing(entry.span, entry.key, message, "Write length_mm and tooth_mm beside it.");
        return None;
    }
    Some(*contact)
}

/// Length, tooth and number of the notches; they must be there when `lists` give one value per notch.
fn read_pattern(
    cursor: &Cursor<'_, '_>,
    lists: &[&Written],
    length: Option<f64>,
    out: &mut Collector,
) -> Option<NotchPattern> {
    let notch = cursor.field("length_mm", &LENGTH, out);
    let tooth = cursor.field("tooth_mm", &LENGTH, out);
    let count_entry = cursor.get("count");
    let count = count_entry.as_ref().map(|entry| entry.count(MOST, out));
    if !(notch.present || tooth.present) {
        for list in lists {
            let message = "one value per notch needs the places of the notches";
            let help = "Write length_mm and tooth_mm beside it, or [base, tip], or a table over x.";
            out.missing(list.span.clone(), list.key.clone(), message, help);
        }
        if let (true, Some(entry)) = (lists.is_empty(), &count_entry) {
            let message = "a number of notches says nothing without their length";
            out.missing(
                entry.span.clone(),
                entry.key.clone(),
                message,
                "Write length_mm and tooth_mm, or leave it out.",
            );
        }
        return None;
    }
    for (key, there, other) in
        [("length_mm", notch.present, "tooth_mm"), ("tooth_mm", tooth.present, "length_mm")]
    {
        if !there {
            let message = format!("this key is missing beside {other}");
            out.missing(cursor.span(), cursor.path(key), message, format!("Write {key} = 5.0."));
        }
    }
    let (notch, tooth, length) = (notch.value?, tooth.value?, length?);
    if length <= 0.0 && lists.is_empty() && count.is_none() {
        // What lies below the plate alone goes on as far as it has to.
        return Some(NotchPattern { length: notch, tooth, count: 0 });
    }
    let pitch = notch + tooth;
    let room = whole(length / pitch + ROUNDING);
    let say = |count: usize| {
        let size = format!("{count} × ({} + {}) mm", print(notch * 1e3), print(tooth * 1e3));
        format!("the pattern is longer than the tube: {size} is more than {}", print_mm(length))
    };
    let fit = if room == 0 {
        format!("Write a length_mm and tooth_mm that together are at most {}.", print(length * 1e3))
    } else {
        format!("There is room for {room}.")
    };
    if room == 0 {
        let span = cursor.get("length_mm").map_or(cursor.span(), |entry| entry.span);
        out.wrong(span, cursor.path("length_mm"), say(1), fit);
        return None;
    }
    let count = match count {
        Some(count) => count?,
        None => room,
    };
    if count > room {
        if let Some(entry) = count_entry {
            entry.wrong(say(count as usize), fit, out);
        }
        return None;
    }
    for list in lists {
        let given = list.numbers.len();
        if given > room as usize {
            out.wrong(list.span.clone(), list.key.clone(), say(given), fit.clone());
        } else if given != count as usize {
            let message = format!("{given} values stand for {count} notches");
            let help = match count_entry {
                Some(_) => "Write one value per notch, or another count.".to_owned(),
                None => format!(
                    "The tube has room for {room} notches: write one value for each, or count = {given} if there are fewer."
                ),
            };
            out.wrong(list.span.clone(), list.key.clone(), message, help);
        }
    }
    Some(NotchPattern { length: notch, tooth, count })
}

/// The whole part of a number, at most [`MOST`].
fn whole(number: f64) -> u32 {
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "clamped to 0..=MOST")]
    let whole = number.clamp(0.0, f64::from(MOST)) as u32;
    whole
}

fn read_torsion(cursor: &Cursor<'_, '_>, length: Option<f64>, out: &mut Collector) -> Option<Torsion> {
    let Some(entry) = cursor.get("torsion") else {
        return Some(Torsion::SaintVenant);
    };
    if matches!(entry.value, DeValue::Table(_)) {
        let table = entry.table(&["stiffness_Nmm2"], out)?;
        let given = table.require("stiffness_Nmm2", "Write { stiffness_Nmm2 = 170.0 }.", out)?;
        return read(&given, &STIFFNESS, false, length, out)?.plain(out).map(Torsion::Given);
    }
    if !matches!(entry.value, DeValue::String(_)) {
        let message = "this must be \"saint-venant\", \"polar\" or a stiffness";
        entry.wrong(message, "Write a stiffness as torsion = { stiffness_Nmm2 = 170.0 }.", out);
        return None;
    }
    match entry.word(&["saint-venant", "polar"], out)? {
        "polar" => Some(Torsion::Polar),
        _ => Some(Torsion::SaintVenant),
    }
}

/// Compares every depth with what there is to cut; true where all of them leave something.
fn check_depths(written: &Written, outline: &Outline, out: &mut Collector) -> bool {
    let limit = outline.depth_limit();
    let help = |most: f64| {
        format!("Write a depth below {}, or leave notches out for an uncut tube.", print(most * 1e3))
    };
    let mut sound = true;
    let many = written.numbers.len() > 1;
    for (index, Number { value, span }) in
        written.numbers.iter().enumerate().filter(|(_, n)| n.value > limit - LEAST_WALL)
    {
        let key = if many { format!("{}, number {}", written.key, index + 1) } else { written.key.clone() };
        let (message, most) = if *value > limit {
            (format!("{} is deeper than the tube is wide ({})", print_mm(*value), print_mm(limit)), limit)
        } else if *value < limit {
            let least = print_mm(LEAST_WALL);
            let message = format!("this leaves less of the tube than any robot has ({least})");
            (message, limit - LEAST_WALL)
        } else {
            (format!("{} cuts the tube through: nothing is left", print_mm(*value)), limit)
        };
        out.wrong(span.clone(), key, message, help(most));
        sound = false;
    }
    if let (Spread::Constant, [number]) = (&written.spread, written.numbers.as_slice())
        && number.value <= 0.0
    {
        let message = "a notch without depth is no notch";
        let help = "Write a depth above 0, or leave notches out for an uncut tube.";
        out.wrong(number.span.clone(), written.key.clone(), message, help);
        sound = false;
    }
    sound
}

/// Looks at the depth between the given ones: a spline may swing beyond them.
fn check_curve(written: &Written, depth: &Profile, outline: &Outline, length: f64, out: &mut Collector) {
    if written.spread != Spread::PerNotch {
        return;
    }
    let worst = (0..=SAMPLES)
        .map(|i| length * f64::from(i) / f64::from(SAMPLES))
        .map(|x| (x, depth.eval(x, length)[0]))
        .find(|(_, value)| !(*value >= -NO_DEPTH && *value < outline.depth_limit() - LEAST_WALL));
    if let Some((x, value)) = worst {
        let message = format!("the curve through these depths is {} at x = {}", print_mm(value), print_mm(x));
        let help = format!(
            "Let the depths change more gently, so that it stays between 0.0 and {}.",
            print(outline.depth_limit() * 1e3)
        );
        out.wrong(written.span.clone(), written.key.clone(), message, help);
    }
}
