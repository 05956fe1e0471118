//! What can be wrong with a question.

use datafusion::error::DataFusionError;

/// A result with [`Error`].
pub type Result<T> = std::result::Result<T, Error>;

/// What is wrong.
#[derive(Debug)]
pub enum Error {
    /// A campaign that is malformed, with its place.
    Campaign(tumble::Malformed),
    /// A campaign that one linear step cannot answer, with what does.
    Step(tumble::Malformed),
    /// A question that does not fit the table.
    Question(String),
    /// What DataFusion says.
    DataFusion(DataFusionError),
}

impl std::fmt::Display for Error {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Error::Campaign(error) => error.fmt(f),
            Error::Step(error) => write!(
                f,
                "tumble_fit() is one linear step, and this campaign needs more: {error}\n\
                 tumble_fit_exact() keeps the rows of a device together and makes the ordinary fit of them"
            ),
            Error::Question(text) => f.write_str(text),
            // what stands around it says which rule found it
            Error::DataFusion(error) => match error.find_root() {
                DataFusionError::Plan(text) => f.write_str(text),
                root => root.fmt(f),
            },
        }
    }
}

impl std::error::Error for Error {}

impl From<tumble::Malformed> for Error {
    fn from(error: tumble::Malformed) -> Self {
        Error::Campaign(error)
    }
}

impl From<DataFusionError> for Error {
    fn from(error: DataFusionError) -> Self {
        Error::DataFusion(error)
    }
}

impl From<Error> for DataFusionError {
    fn from(error: Error) -> Self {
        match error {
            Error::DataFusion(error) => error,
            other => DataFusionError::Plan(other.to_string()),
        }
    }
}
