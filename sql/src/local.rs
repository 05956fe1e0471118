//! A cluster on this machine, for trying: one scheduler and a few executors as processes of their own.

use crate::error::{Error, Result};
use std::net::{SocketAddr, TcpListener, TcpStream};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

/// Longest wait for a process to answer.
const PATIENCE: Duration = Duration::from_secs(120);

/// Processes that end with this value, and their folders.
#[derive(Debug)]
pub struct Local {
    port: u16,
    processes: Vec<Process>,
    folder: PathBuf,
}

#[derive(Debug)]
struct Process {
    child: Child,
    work: PathBuf,
}

impl Local {
    /// Start a scheduler and so many executors of `threads` tasks each; an executor that is silent for `timeout_s` is given up.
    ///
    /// `node` is the program `tumble-sql-node`, which stands beside `tumble-sql`.
    ///
    /// # Errors
    ///
    /// A program that is not there, ports that cannot be had, a process that ends or does not answer.
    pub fn start(node: &Path, executors: usize, threads: usize, timeout_s: u64) -> Result<Self> {
        let failed = |what: &str, error: std::io::Error| Error::Question(format!("{what}: {error}"));
        let free = (0..1 + 2 * executors)
            .map(|_| TcpListener::bind("127.0.0.1:0"))
            .collect::<std::io::Result<Vec<_>>>()
            .map_err(|error| failed("no free port", error))?;
        let ports = free.iter().map(|own| own.local_addr().map(|own| own.port())).collect::<std::io::Result<Vec<_>>>();
        let ports = ports.map_err(|error| failed("no free port", error))?;
        drop(free);
        let [port, rest @ ..] = ports.as_slice() else { return Err(Error::Question("no free port".into())) };
        let folder = std::env::temp_dir().join(format!("tumble-sql-{}-{port}", std::process::id()));
        let mut local = Local { port: *port, processes: Vec::new(), folder };
        local.run(node, *port, &["scheduler", "--port", &port.to_string(), "--timeout", &timeout_s.to_string()])?;
        let scheduler = format!("127.0.0.1:{port}");
        for (k, pair) in rest.chunks_exact(2).enumerate() {
            let work = local.folder.join(k.to_string());
            std::fs::create_dir_all(&work).map_err(|error| failed(&work.display().to_string(), error))?;
            let text =
                [pair[0].to_string(), pair[1].to_string(), threads.max(1).to_string(), work.display().to_string()];
            let [flight, grpc, threads, work] = &text;
            let arguments =
                ["executor", "--scheduler", &scheduler, "--threads", threads, "--work", work, "--ports", flight, grpc];
            local.run(node, pair[0], &arguments)?;
        }
        Ok(local)
    }

    /// The address of the scheduler.
    pub fn url(&self) -> String {
        format!("df://127.0.0.1:{}", self.port)
    }

    /// The folder of what an executor passes on to others.
    pub fn work(&self, executor: usize) -> Option<&Path> {
        self.processes.get(executor + 1).map(|own| own.work.as_path())
    }

    /// End an executor at once, as a machine that fails.
    ///
    /// # Errors
    ///
    /// There is no such executor, or the system does not end it.
    pub fn kill(&mut self, executor: usize) -> Result<()> {
        let own =
            self.processes.get_mut(executor + 1).ok_or_else(|| Error::Question(format!("no executor {executor}")))?;
        let ended = own.child.kill().and_then(|()| own.child.wait());
        ended.map(|_| ()).map_err(|error| Error::Question(format!("executor {executor}: {error}")))
    }

    /// Start a process and wait until it answers at its port.
    fn run(&mut self, node: &Path, port: u16, arguments: &[&str]) -> Result<()> {
        let role = arguments.first().copied().unwrap_or_default();
        let child = Command::new(node).args(arguments).stdin(Stdio::null()).stdout(Stdio::null()).spawn();
        let child = child.map_err(|error| Error::Question(format!("cannot start '{}': {error}", node.display())))?;
        let work = self.folder.join((self.processes.len().saturating_sub(1)).to_string());
        self.processes.push(Process { child, work });
        let begun = Instant::now();
        let address = SocketAddr::from(([127, 0, 0, 1], port));
        while TcpStream::connect_timeout(&address, Duration::from_millis(200)).is_err() {
            let ended = self.processes.last_mut().and_then(|own| own.child.try_wait().ok().flatten());
            if let Some(status) = ended {
                return Err(Error::Question(format!("the {role} ended: {status}")));
            }
            if begun.elapsed() > PATIENCE {
                return Err(Error::Question(format!("the {role} does not answer at port {port}")));
            }
            std::thread::sleep(Duration::from_millis(20));
        }
        Ok(())
    }
}

impl Drop for Local {
    fn drop(&mut self) {
        for own in self.processes.iter_mut().rev() {
            // one that has ended already
            let _ = own.child.kill();
            let _ = own.child.wait();
        }
        let _ = std::fs::remove_dir_all(&self.folder);
    }
}
