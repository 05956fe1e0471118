//! `tumble-sql-node`: a scheduler or an executor of a cluster.

use clap::{Parser, Subcommand};
use std::process::ExitCode;
use tumble_sql::cluster;

/// A process of a cluster: one scheduler, and as many executors as there are machines. All must see the files of readings under the same paths.
#[derive(Debug, Parser)]
#[command(version)]
struct Arguments {
    #[command(subcommand)]
    role: Role,
    /// The address that this process listens on.
    #[arg(long, default_value = "127.0.0.1", global = true)]
    host: String,
}

#[derive(Debug, Subcommand)]
enum Role {
    /// Deals work to executors.
    Scheduler {
        /// Its port.
        #[arg(long, default_value_t = 50050)]
        port: u16,
        /// Seconds after which an executor that is silent is given up.
        #[arg(long, default_value_t = 60)]
        timeout: u64,
    },
    /// Does the work.
    Executor {
        /// The scheduler, as HOST:PORT.
        #[arg(long, default_value = "127.0.0.1:50050")]
        scheduler: String,
        /// Two ports of its own.
        #[arg(long, num_args = 2, default_values_t = [50051, 50052])]
        ports: Vec<u16>,
        /// Tasks at a time.
        #[arg(long, default_value_t = 1)]
        threads: usize,
        /// Where it keeps what it passes on to other executors; a folder for temporary files unless given.
        #[arg(long, value_name = "FOLDER")]
        work: Option<String>,
    },
}

fn main() -> ExitCode {
    let Arguments { role, host } = Arguments::parse();
    let done =
        tokio::runtime::Builder::new_multi_thread().enable_all().build().map_err(|error| error.to_string()).and_then(
            |runtime| {
                runtime.block_on(async {
                    match role {
                        Role::Scheduler { port, timeout } => {
                            cluster::scheduler(&host, port, timeout).await.map_err(|error| error.to_string())
                        }
                        Role::Executor { scheduler, ports, threads, work } => {
                            let address =
                                scheduler.rsplit_once(':').and_then(|(host, port)| Some((host, port.parse().ok()?)));
                            let address = address.ok_or(format!("'{scheduler}' is no HOST:PORT"))?;
                            let [flight, grpc] = ports[..] else { return Err("two ports are needed".to_string()) };
                            let done = cluster::executor(address, &host, [flight, grpc], threads, work).await;
                            done.map_err(|error| error.to_string())
                        }
                    }
                })
            },
        );
    match done {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("error: {error}");
            ExitCode::FAILURE
        }
    }
}
