# The few commands a newcomer needs. 'make help' lists them.

CARGO ?= cargo
PROGRAM = target/release/subdiv-rtl

.PHONY: all build demo test lint bench tools fpga-tools clean help
.NOTPARALLEL:

all: build

build: ## Build the program (release)
	@sh tools/install.sh rust
	$(CARGO) build --release --locked
	@echo "The program is $(PROGRAM)."

demo: ## Simulate the blob at level 5 in every simulator, draw it
	@sh tools/install.sh all
	$(CARGO) build --release --locked
	@mkdir -p demo
	$(PROGRAM) simulate --shape blob --level 5 --simulator installed \
	    -o demo/blob.obj --picture demo/blob.png --control-mesh
	@echo "The fine mesh is demo/blob.obj, its picture demo/blob.png."

test: ## Run everything: format, lints, all tests (the slow ones too)
	@sh tools/install.sh all
	@sh tools/install.sh ecp5
	$(CARGO) fmt --all --check
	$(CARGO) clippy --profile quick --all-targets --locked -- -D warnings
	$(CARGO) test --profile quick --locked --no-fail-fast --lib --bins --tests
	$(CARGO) test --profile quick --locked --doc

lint: ## Check format and lints
	$(CARGO) fmt --all --check
	$(CARGO) clippy --all-targets --locked -- -D warnings

bench: ## Measure the speeds that the README states
	@sh tools/install.sh all
	$(CARGO) bench --locked

tools: ## Find what is missing (C++ compiler, Verilator, Icarus, Yosys, tools for FPGAs) and install it
	@sh tools/install.sh all
	@sh tools/install.sh fpga

fpga-tools: ## Only the tools for FPGAs: Yosys and nextpnr, 160 MB, into a folder of their own
	@sh tools/install.sh fpga

clean: ## Remove what was built
	$(CARGO) clean
	rm -rf demo

help: ## List these commands
	@awk -F ': ## ' '/^[a-z-]+: ## / { printf "  make %-10s %s\n", $$1, $$2 }' Makefile
