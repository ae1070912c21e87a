//! Why a file cannot be read.

/// The error of a file that cannot be read.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum LoadError {
    /// The file or one that it names cannot be fetched.
    #[error("{file}: {message}")]
    Io {
        /// The model's file.
        file: String,
        /// What went wrong and what to do.
        message: String,
    },
    /// The file is not valid glTF 2.0.
    #[error("{file}: {}{message}", place(pointer))]
    Invalid {
        /// The model's file.
        file: String,
        /// The JSON pointer of what is wrong; empty for the whole file.
        pointer: String,
        /// What was expected and what to do.
        message: String,
    },
    /// The file is not valid in a format other than glTF.
    #[error("{file}: {}{message}", place_before(place))]
    Malformed {
        /// The model's file.
        file: String,
        /// What is wrong: `line 5`, `byte 84`; empty for the whole file.
        place: String,
        /// What was expected and what to do.
        message: String,
    },
    /// The file requires an extension that is not supported.
    #[error(
        "{file}: at \"/extensionsRequired\": requires {extension}, which is not supported; \
         export the model again without it"
    )]
    UnsupportedExtension {
        /// The model's file.
        file: String,
        /// The name of the extension.
        extension: String,
    },
}

/// Where something is, for a message; nothing for the whole file.
fn place(pointer: &str) -> String {
    if pointer.is_empty() { String::new() } else { format!("at \"{pointer}\": ") }
}

/// The same of other formats.
fn place_before(place: &str) -> String {
    if place.is_empty() { String::new() } else { format!("{place}: ") }
}

impl LoadError {
    /// An error at a place of a file that is not glTF.
    pub(crate) fn malformed(place: &str, message: impl Into<String>) -> Self {
        Self::Malformed { file: String::new(), place: place.to_owned(), message: message.into() }
    }

    /// An error at `pointer`; [`super::load_bytes`] adds the file's name.
    pub(super) fn invalid(pointer: &str, message: impl Into<String>) -> Self {
        Self::Invalid { file: String::new(), pointer: pointer.to_owned(), message: message.into() }
    }

    /// Where it is in the JSON of a glTF file; empty for the whole file.
    pub(super) fn pointer(&self) -> &str {
        if let Self::Invalid { pointer, .. } = self { pointer } else { "" }
    }

    /// What went wrong, without the place.
    pub(super) fn into_message(self) -> String {
        match self {
            Self::Io { message, .. } | Self::Invalid { message, .. } | Self::Malformed { message, .. } => message,
            unsupported @ Self::UnsupportedExtension { .. } => unsupported.to_string(),
        }
    }

    pub(crate) fn in_file(mut self, name: &str) -> Self {
        let (Self::Io { file, .. }
        | Self::Invalid { file, .. }
        | Self::Malformed { file, .. }
        | Self::UnsupportedExtension { file, .. }) = &mut self;
        name.clone_into(file);
        self
    }
}
