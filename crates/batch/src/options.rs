//! Options that an asset has of its own, from a list or a configuration: those of commands, by
//! their long names.

use std::collections::BTreeMap;

/// The option whose values have keys: each key counts by itself, the last one given.
pub const LIMIT: &str = "limit";

/// Values of options by long name, without dashes. A switch has none.
#[derive(Clone, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub struct OptionValues(pub BTreeMap<String, Vec<String>>);

impl OptionValues {
    /// Reads them from a JSON object. `false` says that a switch is off, like leaving it out.
    ///
    /// # Errors
    /// If a value is neither text, number, true, false nor a list of texts and numbers.
    pub fn from_json<'a>(
        object: impl IntoIterator<Item = (&'a String, &'a serde_json::Value)>,
    ) -> Result<Self, String> {
        use serde_json::Value;
        let one = |name: &str, value: &Value| match value {
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
                    list.iter().map(|v| one(name, v)).collect::<Result<_, _>>()?
                }
                value => vec![one(name, value)?],
            };
            values.insert(name.clone(), list);
        }
        Ok(Self(values))
    }

    /// Those of `stronger`, and these where it has none, nor one that excludes them. Limits are
    /// known by their keys: of both, those of `stronger` come last and count.
    #[must_use]
    pub fn under(mut self, mut stronger: Self, command: &CommandOptions) -> Self {
        for name in command.excluded(stronger.0.keys()) {
            self.0.remove(name);
        }
        if let Some(last) = stronger.0.get_mut(LIMIT)
            && let Some(mut limits) = self.0.remove(LIMIT)
        {
            limits.append(last);
            *last = limits;
        }
        self.0.extend(stronger.0);
        self
    }
}

/// The options of a command that belong to assets.
#[derive(Clone, Debug)]
pub struct CommandOptions {
    /// The command.
    pub name: String,
    /// Long names of its options.
    pub options: Vec<String>,
    /// Long names of those of which only one can be given, group by group.
    pub exclusive: Vec<Vec<String>>,
}

impl CommandOptions {
    /// Returns whether it has an option of this long name.
    #[must_use]
    pub fn has(&self, option: &str) -> bool {
        self.options.iter().any(|name| name == option)
    }

    /// The long names of options that cannot be combined with those of these names.
    pub fn excluded<'a>(
        &'a self,
        names: impl IntoIterator<Item = &'a String>,
    ) -> impl Iterator<Item = &'a str> {
        let names: Vec<&String> = names.into_iter().collect();
        let groups = self.exclusive.iter();
        let met = groups.filter(move |group| group.iter().any(|name| names.contains(&name)));
        met.flatten().map(String::as_str)
    }
}

/// The words of a program that lists and configurations may use.
#[derive(Clone, Debug)]
pub struct Vocabulary {
    /// Its commands.
    pub commands: Vec<CommandOptions>,
    /// Long names of options that belong to a run, not to an asset.
    pub of_the_run: &'static [&'static str],
    /// Checks the options of a part, a JSON object as text; an error says what is wrong with them.
    pub check_part: fn(&str) -> Result<(), String>,
}

impl Vocabulary {
    /// The options of a command.
    ///
    /// # Panics
    /// If there is no such command.
    #[must_use]
    pub fn of(&self, command: &str) -> &CommandOptions {
        self.commands.iter().find(|c| c.name == command).expect("a command of the program")
    }

    /// Returns whether a command has this name.
    pub(crate) fn is_command(&self, name: &str) -> bool {
        self.commands.iter().any(|c| c.name == name)
    }

    /// The option of these commands whose name is most like a wrong one; none if none is.
    pub(crate) fn suggestion<'a>(wrong: &str, commands: &[&'a CommandOptions]) -> Option<&'a str> {
        let names = commands.iter().flat_map(|c| c.options.iter().map(String::as_str));
        let near = names.map(|name| (strsim::jaro(wrong, name), name)).filter(|(s, _)| *s > 0.7);
        near.max_by(|a, b| a.0.total_cmp(&b.0)).map(|(_, name)| name)
    }
}
