//! Every workaround for a bug or a limit of a tool: what is affected, and how to see it.

use std::io::{self, ErrorKind};
use std::process::{Child, Command};
use std::time::Duration;

/// Bits of one number in a vector file; a wider `tdata` is cut into several numbers.
///
/// Verilator 5.006 (and newer: `VL_VALUE_STRING_MAX_WIDTH`) refuses arguments of more than 8192 bits in
/// `$fscanf`, `$fwrite` and `$display`; half of it keeps the lines of scanned text within its buffer.
///
/// ```verilog
/// reg [8192:0] wide;
/// initial $display("%h", wide);  // %Error: Exceeded limit of 8192 bits for any $display-like arguments
/// ```
pub(super) const FIELD_BITS: u32 = 4096;

/// The register that `$fscanf` fills with the bits of `tdata` from `lsb` on, when it is cut.
///
/// Verilator 5.006 hands `$fscanf` the address of a copy when an argument is a part of a register: what
/// was read is lost, or the C++ does not compile. A whole register is right.
///
/// ```verilog
/// reg [127:0] pair;
/// initial if ($fscanf(file, "%h %h", pair[127:64], pair[63:0]) == 2) $display("%h", pair);
/// ```
pub(super) fn scanned_part(lsb: u32) -> String {
    format!("tdata_{lsb}")
}

/// A number for `$value$plusargs`, always in hexadecimal.
///
/// Verilator 5.006 reads `%d` wrongly into registers whose width is not that of a C integer; `%h` is
/// right at any width.
///
/// ```verilog
/// reg [36:0] count;
/// initial if ($value$plusargs("count=%d", count) != 0) $display("%0d", count);  // +count=5
/// ```
pub(super) fn plus_argument(name: &str, number: u64) -> String {
    format!("+{name}={number:x}")
}

/// Starts a program that was written a moment ago.
///
/// On Linux, a process forked by another thread holds the file open for writing until it has replaced
/// itself, and starting the file fails with `ETXTBSY`. To see it: write a program and start it, in many
/// threads at once.
pub(super) fn spawn_when_not_busy(command: &mut Command) -> io::Result<Child> {
    for _ in 0..200 {
        match command.spawn() {
            Err(error) if error.kind() == ErrorKind::ExecutableFileBusy => {
                std::thread::sleep(Duration::from_millis(10));
            }
            other => return other,
        }
    }
    command.spawn()
}
