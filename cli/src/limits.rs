//! Options of imports: limits on size, memory and processor time, further folders that may be read,
//! welding.

use crate::clock::Clock;
use crate::exit::{Failure, Outcome, Status};
use crate::help::{LIMITS, READ};
use crate::huge_pages;
use crate::jobs::{Budget, LIMIT_OPTION};
use clap::{Arg, ArgAction, ArgMatches, Args, Command, FromArgMatches};
use lodc::pipeline::{Need, Size};
use lodc_formats::import::ImportOptions;
use lodc_formats::{Assets, Limits};
use lodc_report::text::{count, size as size_text};
use std::path::{Path, PathBuf};
use std::time::Duration;

/// Options of reading inputs, shared by every command that reads a mesh.
#[derive(Args, Clone, Debug)]
pub(crate) struct ImportArgs {
    /// Join positions closer than EPS times the bounding box's diagonal
    ///
    /// From 0 (identical positions only) to below 1.
    #[arg(long, value_name = "EPS", default_value = "0", value_parser = weld,
          help_heading = READ, hide_short_help = true)]
    weld: f64,
    /// Also read files under DIR that the input refers to
    ///
    /// Without it only files in the input's own folder and below are read. May be given several
    /// times.
    #[arg(long, value_name = "DIR", help_heading = READ, hide_short_help = true)]
    allow_path: Vec<PathBuf>,
    #[command(flatten)]
    limits: LimitArgs,
}

impl ImportArgs {
    pub(crate) fn options(&self) -> ImportOptions {
        ImportOptions {
            limits: self.limits.limits(),
            allowed: self.allow_path.clone(),
            weld: self.weld,
        }
    }
    pub(crate) fn limits(&self) -> &LimitArgs {
        &self.limits
    }
    /// Further folders that may be read.
    pub(crate) fn allowed(&self) -> &[PathBuf] {
        &self.allow_path
    }
    /// Starts the clock of an asset.
    pub(crate) fn clock(&self, input: &Path) -> Clock {
        self.limits.clock(input)
    }
    /// The files that an asset names, in its own folder or in `folder`.
    pub(crate) fn assets(&self, input: &Path, folder: Option<&PathBuf>) -> Assets {
        // `Assets` uses only the parent of this path.
        let main = folder.map_or_else(|| input.to_owned(), |folder| folder.join("-"));
        Assets::new(&main, &self.allow_path, self.limits.limits())
    }
}

/// The limits themselves. Reaching one ends with status 5.
#[derive(Clone, Debug, Default)]
pub(crate) struct LimitArgs {
    limits: Limits,
    /// Bytes; none for what the machine has.
    memory: Option<u64>,
    /// Processor time; none for no limit.
    time: Option<Duration>,
}

/// A key of `--limit`.
#[derive(Debug)]
struct Key {
    name: &'static str,
    /// What the key counts, for the help.
    description: &'static str,
    default: Preset,
    /// Parses a value.
    parse: fn(&str) -> Result<u64, String>,
    set: fn(&mut LimitArgs, u64),
}

/// The default of a key, for the help.
#[derive(Debug)]
enum Preset {
    /// A multiple of 1 Mi.
    Number(u64),
    Text(&'static str),
}

const KEYS: [Key; 8] = [
    Key {
        name: "file",
        description: "bytes of a single file",
        default: Preset::Number(Limits::DEFAULT.file_bytes),
        parse: size,
        set: |args, number| args.limits.file_bytes = number,
    },
    Key {
        name: "total",
        description: "bytes of all files of one input together",
        default: Preset::Number(Limits::DEFAULT.total_bytes),
        parse: size,
        set: |args, number| args.limits.total_bytes = number,
    },
    Key {
        name: "line",
        description: "bytes of a line of a text format",
        default: Preset::Number(Limits::DEFAULT.line_bytes),
        parse: size,
        set: |args, number| args.limits.line_bytes = number,
    },
    Key {
        name: "vertices",
        description: "vertices",
        default: Preset::Number(Limits::DEFAULT.vertices),
        parse: size,
        set: |args, number| args.limits.vertices = number,
    },
    Key {
        name: "triangles",
        description: "triangles",
        default: Preset::Number(Limits::DEFAULT.triangles),
        parse: size,
        set: |args, number| args.limits.triangles = number,
    },
    Key {
        name: "memory",
        description: "bytes that the work on one input may be expected to need",
        default: Preset::Text("what the machine has"),
        parse: size,
        set: |args, number| args.memory = Some(number),
    },
    Key {
        name: "pixels",
        description: "pixels of all images of one input that are decoded",
        default: Preset::Number(Limits::DEFAULT.pixels),
        parse: size,
        set: |args, number| args.limits.pixels = number,
    },
    Key {
        name: "time",
        description: "processor time of the work on one input: 90s, 500ms, 5m, 1h",
        default: Preset::Text("none"),
        parse: milliseconds,
        set: |args, number| args.time = Some(Duration::from_millis(number)),
    },
];

impl Args for LimitArgs {
    fn augment_args(command: Command) -> Command {
        let limit = Arg::new(LIMIT_OPTION)
            .long(LIMIT_OPTION)
            .value_name("KEY=VALUE")
            .action(ArgAction::Append)
            .value_parser(limit)
            .help("Limit on each input, such as memory=8G (see --help)")
            .long_help(long_help())
            .help_heading(LIMITS)
            .hide_short_help(true);
        command.arg(limit)
    }

    fn augment_args_for_update(command: Command) -> Command {
        Self::augment_args(command)
    }
}

/// The help of `--limit`, with every key.
fn long_help() -> String {
    let default = |number: u64| match number.trailing_zeros() {
        30.. => format!("{}G", number >> 30),
        _ => format!("{}M", number >> 20),
    };
    let line = |key: &Key| {
        let default = match key.default {
            Preset::Number(number) => default(number),
            Preset::Text(text) => text.to_owned(),
        };
        format!("\n  {:10} {} ({default})", key.name, key.description)
    };
    let lines: String = KEYS.iter().map(line).collect();
    format!(
        "Limit on each input, such as memory=8G\n\nMay be given several times; of several for one \
         key the last counts. Reaching a limit ends with status 5. Values are whole numbers, with \
         K, M, G or T behind them for powers of 1024. Keys and their defaults:\n{lines}\n\nAssets \
         that are worked on together share the time of the process evenly. What is finished is \
         the same with and without a limit."
    )
}

impl FromArgMatches for LimitArgs {
    fn from_arg_matches(matches: &ArgMatches) -> Result<Self, clap::Error> {
        let mut args = Self::default();
        args.update_from_arg_matches(matches)?;
        Ok(args)
    }

    fn update_from_arg_matches(&mut self, matches: &ArgMatches) -> Result<(), clap::Error> {
        for limit in matches.get_many::<Limit>(LIMIT_OPTION).into_iter().flatten() {
            (limit.key.set)(self, limit.number);
        }
        Ok(())
    }
}

/// A limit as it was given.
#[derive(Clone, Copy, Debug)]
struct Limit {
    key: &'static Key,
    number: u64,
}

/// Reads `memory=8G`.
fn limit(text: &str) -> Result<Limit, String> {
    let read = || {
        let (name, number) = text.split_once('=').ok_or("KEY=VALUE is needed")?;
        let key = KEYS.iter().find(|key| key.name == name);
        let key = key.ok_or_else(|| format!("unknown key {name}"))?;
        Ok(Limit { key, number: (key.parse)(number)? })
    };
    read().map_err(|why: String| {
        let names: Vec<&str> = KEYS.iter().map(|key| key.name).collect();
        format!("{why}; keys are {}", names.join(", "))
    })
}

impl LimitArgs {
    pub(crate) fn limits(&self) -> Limits {
        self.limits
    }

    /// Bytes of memory that may be used: what was asked for, or what the machine has; none if
    /// unknown.
    pub(crate) fn memory(&self) -> Option<u64> {
        self.memory.or_else(crate::memory::available_bytes)
    }

    /// Workers and memory of a run; memory is unbounded where it is unknown.
    pub(crate) fn budget(&self) -> Budget {
        let bytes = self.memory().unwrap_or(u64::MAX);
        Budget { workers: rayon::current_num_threads(), bytes }
    }

    /// Starts the clock of an asset.
    pub(crate) fn clock(&self, input: &Path) -> Clock {
        Clock::start(input, self.time)
    }

    /// Refuses work on an asset that would not fit into memory, before the system kills the process
    /// for it. `name` is the asset's, `needs` are those of the stages that follow. Also forbids
    /// huge pages for large work, and for work in little memory.
    ///
    /// # Errors
    /// If a stage needs more than there is, or than `--limit memory=` allows.
    pub(crate) fn check_memory(&self, name: &str, size: Size, needs: &[Need]) -> Outcome<()> {
        let (largest, limit) = (needs.iter().max(), self.memory());
        huge_pages::forbid_for(largest.map_or(0, |need| need.bytes), limit);
        match (largest, limit) {
            (Some(Need { bytes, stage }), Some(limit)) if *bytes > limit => Err(Failure::new(
                Status::Limit,
                format!(
                    "{name}: {} may need {} of memory (stage {stage}), more than the limit of {} \
                     (--limit memory=SIZE)",
                    count(size.triangles, "triangle"),
                    size_text(*bytes),
                    size_text(limit)
                ),
            )),
            _ => Ok(()),
        }
    }
}

fn weld(text: &str) -> Result<f64, String> {
    let value = text.parse().ok().filter(|value| (0.0..1.0).contains(value));
    value.ok_or_else(|| "must be a number from 0 to below 1, such as 0.001".to_owned())
}

/// A count or size with an optional power of 1024: `123`, `64K`, `2G`.
fn size(text: &str) -> Result<u64, String> {
    let (digits, shift) =
        match text.char_indices().next_back().map(|(i, c)| (i, c.to_ascii_uppercase())) {
            Some((i, 'K')) => (&text[..i], 10),
            Some((i, 'M')) => (&text[..i], 20),
            Some((i, 'G')) => (&text[..i], 30),
            Some((i, 'T')) => (&text[..i], 40),
            _ => (text, 0),
        };
    let wrong = || "a whole number, with or without K, M, G or T, is needed".to_owned();
    let number: u64 = digits.parse().map_err(|_| wrong())?;
    number.checked_mul(1 << shift).ok_or_else(|| "too large".to_owned())
}

/// Milliseconds of a time, which is seconds unless a unit says otherwise: `60`, `90s`, `500ms`.
fn milliseconds(text: &str) -> Result<u64, String> {
    let digits = text.trim_end_matches(|c: char| c.is_ascii_alphabetic());
    let unit = match &text[digits.len()..] {
        "ms" => 1,
        "" | "s" => 1_000,
        "m" => 60_000,
        "h" => 3_600_000,
        _ => return Err("a time is in ms, s, m or h".to_owned()),
    };
    let number = digits.parse::<u64>();
    let number = number.map_err(|_| "a whole number of seconds, or with ms, m or h, is needed")?;
    number.checked_mul(unit).ok_or_else(|| "too large".to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sizes_take_powers_of_1024_and_refuse_what_does_not_fit() {
        assert_eq!(size("12"), Ok(12));
        assert_eq!(size("64k"), Ok(64 << 10));
        assert_eq!(size("2G"), Ok(2 << 30));
        for wrong in ["", "K", "-1", "1.5M", "99999999999T", "3X", "é"] {
            assert!(size(wrong).is_err(), "{wrong}");
        }
    }

    fn given(words: &[&str]) -> Result<LimitArgs, clap::Error> {
        let command = LimitArgs::augment_args(Command::new("lodc"));
        let matches = command.try_get_matches_from(["lodc"].iter().chain(words))?;
        LimitArgs::from_arg_matches(&matches)
    }

    #[test]
    fn each_key_sets_its_limit_and_the_last_counts() {
        let numbers = |args: &LimitArgs| {
            let limits = args.limits();
            let seconds = args.time.map(|time| time.as_secs());
            let sizes = [limits.file_bytes, limits.total_bytes, limits.line_bytes];
            sizes
                .into_iter()
                .chain([limits.vertices, limits.triangles])
                .map(Some)
                .chain([args.memory, Some(limits.pixels), seconds])
                .collect::<Vec<_>>()
        };
        let before = numbers(&given(&[]).expect("no limits"));
        for (index, key) in KEYS.iter().enumerate() {
            let is_time = key.name == "time";
            let (texts, number) =
                if is_time { (["18h", "64800"], 64_800) } else { (["64k", "64K"], 64 << 10) };
            let mut expected = before.clone();
            expected[index] = Some(number);
            for text in texts {
                let (one, keyed) = (format!("{}=1", key.name), format!("{}={text}", key.name));
                assert_eq!(numbers(&given(&["--limit", &keyed]).expect("limits")), expected);
                let words = ["--limit", &one, "--limit", &keyed];
                assert_eq!(numbers(&given(&words).expect("limits")), expected, "{words:?}");
            }
        }
    }

    #[test]
    fn wrong_limits_are_answered_with_the_keys() {
        let wrong = ["", "memory", "memory=", "memory=x", "=1", "Memory=1", "vertex=1", "line=-1"];
        for wrong in wrong.into_iter().chain(["time=1K", "time=x"]) {
            let why = limit(wrong).expect_err(wrong);
            assert!(KEYS.iter().all(|key| why.contains(key.name)), "{wrong}: {why}");
        }
    }

    #[test]
    fn times_have_units() {
        let known = [("0s", 0), ("7ms", 7), ("60", 60_000), ("60s", 60_000), ("2m", 120_000)];
        for (text, time) in known.into_iter().chain([("1h", 3_600_000)]) {
            assert_eq!(milliseconds(text), Ok(time), "{text}");
        }
        for wrong in ["", "s", "-1s", "1.5s", "1 s", "3K", "1d", "99999999999999999h", "é", "1é"]
        {
            assert!(milliseconds(wrong).is_err(), "{wrong}");
        }
    }

    #[test]
    fn welding_takes_a_share_below_one() {
        assert_eq!(weld("0.001"), Ok(0.001));
        for wrong in ["1", "-0.1", "NaN", "inf", "x"] {
            assert!(weld(wrong).is_err(), "{wrong}");
        }
    }
}
