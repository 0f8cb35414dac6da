//! Options of commands by their long names, as lists and configurations give them to assets.

use std::collections::BTreeMap;
use std::rc::Rc;

/// The option whose values are `KEY=VALUE`: of the values of each key the last one counts.
pub(crate) const LIMIT_OPTION: &str = "limit";

/// The values of options by long name, without dashes; a switch that is on has an empty list.
#[derive(Clone, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct OptionValues(pub BTreeMap<String, Vec<String>>);

impl OptionValues {
    /// Reads them from a JSON object. `false` turns a switch off, the same as leaving it out.
    ///
    /// # Errors
    /// If a value is neither text, number, true, false nor a list of texts and numbers.
    pub(crate) fn from_json<'a>(
        object: impl IntoIterator<Item = (&'a String, &'a serde_json::Value)>,
    ) -> Result<Self, String> {
        use serde_json::Value;
        let text = |name: &str, value: &Value| match value {
            Value::String(text) => Ok(text.clone()),
            Value::Number(number) => Ok(number.to_string()),
            _ => Err(format!("option {name}: a text, a number, true, false or a list is needed")),
        };
        let mut values = BTreeMap::new();
        for (name, value) in object {
            let list = match value {
                Value::Bool(false) => continue,
                Value::Bool(true) => vec![],
                Value::Array(list) => {
                    list.iter().map(|v| text(name, v)).collect::<Result<_, _>>()?
                }
                value => vec![text(name, value)?],
            };
            values.insert(name.clone(), list);
        }
        Ok(Self(values))
    }

    /// Returns `stronger` with those of these options that it neither has nor excludes. Limits of
    /// both are kept: those of `stronger` come last, so they count where the keys are the same.
    #[must_use]
    pub(crate) fn overridden_by(mut self, mut stronger: Self, command: &CommandOptions) -> Self {
        for name in command.excluded(stronger.0.keys()) {
            self.0.remove(name);
        }
        if let Some(stronger_limits) = stronger.0.get_mut(LIMIT_OPTION)
            && let Some(mut limits) = self.0.remove(LIMIT_OPTION)
        {
            limits.append(stronger_limits);
            *stronger_limits = limits;
        }
        self.0.extend(stronger.0);
        self
    }
}

/// The options of a command that can differ between the assets of a run.
#[derive(Clone, Debug)]
pub(crate) struct CommandOptions {
    /// The name of the command.
    pub(crate) name: String,
    /// Long names of its options.
    pub(crate) options: Vec<String>,
    /// Long names of those that take no value.
    pub(crate) switches: Vec<String>,
    /// Groups of long names; of each group only one option can be given.
    pub(crate) exclusive_groups: Vec<Vec<String>>,
}

impl CommandOptions {
    /// Returns whether it has an option of this long name.
    #[must_use]
    pub(crate) fn has(&self, option: &str) -> bool {
        self.options.iter().any(|name| name == option)
    }

    /// Long names of the options that are in a group with one of `names`, these included.
    pub(crate) fn excluded<'a>(
        &'a self,
        names: impl IntoIterator<Item = &'a String>,
    ) -> impl Iterator<Item = &'a str> {
        let names: Vec<&String> = names.into_iter().collect();
        let groups = self.exclusive_groups.iter();
        let groups = groups.filter(move |group| group.iter().any(|name| names.contains(&name)));
        groups.flatten().map(String::as_str)
    }
}

/// The names that lists and configurations may use: the commands of a program and their options.
#[derive(Clone, Debug)]
pub(crate) struct Vocabulary {
    /// Its commands.
    pub(crate) commands: Vec<CommandOptions>,
    /// Long names of options that hold for a whole run, so no asset can have them of its own.
    pub(crate) run_options: &'static [&'static str],
    /// Checks the options of a part, a JSON object as text; an error says what is wrong with them.
    pub(crate) check_part: fn(&str) -> Result<(), String>,
    /// Checks a value of an option that takes one.
    pub(crate) check_value: ValueCheck,
}

/// Takes a command, one of its options and a value; an error says what the value must be.
type CheckValue = dyn Fn(&str, &str, &str) -> Result<(), String>;

/// Checks values of options.
#[derive(Clone)]
pub(crate) struct ValueCheck(pub Rc<CheckValue>);

impl std::fmt::Debug for ValueCheck {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("ValueCheck").finish_non_exhaustive()
    }
}

impl Vocabulary {
    /// The options of a command.
    ///
    /// # Panics
    /// If there is no such command.
    #[must_use]
    pub(crate) fn command(&self, command: &str) -> &CommandOptions {
        self.commands.iter().find(|c| c.name == command).expect("a command of the program")
    }

    /// Returns whether a command has this name.
    pub(crate) fn is_command(&self, name: &str) -> bool {
        self.commands.iter().any(|c| c.name == name)
    }
}

/// The name that is most like an unknown one, if one is like it.
pub(super) fn suggestion<'a>(
    unknown: &str,
    names: impl IntoIterator<Item = &'a str>,
) -> Option<&'a str> {
    /// Jaro similarity, 0 to 1, from which a name is suggested. Chosen by hand: less, and
    /// options that have nothing to do with the unknown one are suggested.
    const LEAST_SIMILARITY: f64 = 0.7;
    let names = names.into_iter().map(|name| (strsim::jaro(unknown, name), name));
    let similar = names.filter(|(similarity, _)| *similarity > LEAST_SIMILARITY);
    similar.max_by(|a, b| a.0.total_cmp(&b.0)).map(|(_, name)| name)
}
