//! Damaged robot files are refused or read, and never make the reader panic.
#![allow(clippy::panic, clippy::unwrap_used, clippy::expect_used, reason = "a test fails by panicking")]

use cppr_io::robot_file;

const ROBOTS: [&str; 7] = [
    include_str!("../../../robots/r1.toml"),
    include_str!("../../../robots/r2.toml"),
    include_str!("../../../robots/r3.toml"),
    include_str!("../../../robots/r4.toml"),
    include_str!("../../../robots/childs2.toml"),
    include_str!("../../../robots/childs3.toml"),
    include_str!("../../../robots/helicoid.toml"),
];
const TOKENS: [&str; 36] = [
    "nan",
    "-inf",
    "1e308",
    "1e-320",
    "-0.0",
    "0",
    "9223372036854775807",
    "99999999999999999999",
    "0xff",
    "0b1",
    "true",
    "\"\"",
    "\"x",
    "'''",
    "[",
    "]",
    "[[",
    "{",
    "}",
    "{}",
    "[]",
    "=",
    ",",
    ".",
    "\n",
    "#",
    "\u{feff}",
    "é",
    "\u{0}",
    "[1, 2, 3]",
    "[5, 5]",
    "{ x_mm = [0, 50, 100], depth_mm = [1, 2, 1.5] }",
    "[tube.stiffness]\n",
    "[[tube]]\n",
    "torsion = { stiffness_Nmm2 = [1, 2] }\n",
    "length_mm",
];
const MUTATIONS: u32 = 20_000;

/// A linear congruential generator (Knuth's MMIX): the same mutations in every run.
struct Dice(u64);

impl Dice {
    fn below(&mut self, limit: usize) -> usize {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        // The high bits are the random ones; 31 of them fit into any usize.
        usize::try_from(self.0 >> 33).map_or(0, |number| number % limit.max(1))
    }
}

fn mutate(bytes: &mut Vec<u8>, dice: &mut Dice) {
    let at = dice.below(bytes.len());
    let end = (at + 1 + dice.below(24)).min(bytes.len());
    match dice.below(7) {
        0 => drop(bytes.drain(at..end)),
        1 => {
            let piece = bytes[at..end].to_vec();
            let to = dice.below(bytes.len());
            bytes.splice(to..to, piece);
        }
        2 => bytes[at] = u8::try_from(dice.below(256)).unwrap_or(b'?'),
        3 => {
            let token = TOKENS[dice.below(TOKENS.len())].bytes();
            bytes.splice(at..at, token);
        }
        // Most of the reader's rules are about the value after an equals sign.
        4 | 5 => {
            let signs: Vec<usize> = (0..bytes.len()).filter(|&i| bytes[i] == b'=').collect();
            if let Some(&sign) = signs.get(dice.below(signs.len())) {
                let stop = bytes[sign..].iter().position(|&b| b == b'\n').map_or(bytes.len(), |n| sign + n);
                let token = TOKENS[dice.below(TOKENS.len())].bytes();
                bytes.splice(sign + 1..stop, token);
            }
        }
        _ => {
            let lines: Vec<Vec<u8>> = bytes.split(|&b| b == b'\n').map(<[u8]>::to_vec).collect();
            let mut order = lines.clone();
            order.swap(dice.below(lines.len()), dice.below(lines.len()));
            *bytes = order.join(&b'\n');
        }
    }
    if bytes.is_empty() {
        bytes.push(b'\n');
    }
}

#[test]
fn mutated_robots_never_panic() {
    let mut dice = Dice(1);
    let (mut sound, mut wrong) = (0_u32, 0_u32);
    for round in 0..MUTATIONS {
        let mut bytes = ROBOTS[round as usize % ROBOTS.len()].as_bytes().to_vec();
        for _ in 0..=dice.below(4) {
            mutate(&mut bytes, &mut dice);
        }
        match robot_file::parse_bytes(&bytes) {
            Ok(robot) => {
                assert!(robot.design.length > 0.0 && !robot.design.tubes.is_empty());
                assert_eq!(robot.design.tubes.len(), robot.tubes.len());
                sound += 1;
            }
            Err(problems) => {
                assert!(!problems.list.is_empty());
                assert!(!problems.to_string().is_empty());
                for problem in &problems.list {
                    assert!(problem.excerpt.as_ref().is_none_or(|e| e.length >= 1 && e.length <= 101));
                }
                wrong += 1;
            }
        }
    }
    // A mutator that only made rubbish, or none, would test nothing.
    assert!(sound > MUTATIONS / 50 && wrong > MUTATIONS / 4, "{sound} sound, {wrong} wrong");
}
