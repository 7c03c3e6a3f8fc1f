// board_top: {{ page.title }}, pins and clock around mesh_board.
//
// Written by subdiv-rtl {{ page.version }}; do not edit, generate it again:
//   {{ page.command }}
// {{ page.oscillator }} MHz * {{ page.pll.feedback }} / {{ page.pll.input }} = {{ page.clock }} MHz

`default_nettype none

module board_top (
    input wire clock,
    input wire button,
{%- for (name, _) in page.pins.high %}
    output wire {{ name }},
{%- endfor %}
    output wire led_busy,
    output wire led_done,
    output wire txd
);

    wire aclk;
    wire locked;

    (* FREQUENCY_PIN_CLKI = "{{ page.oscillator }}", FREQUENCY_PIN_CLKOP = "{{ page.clock }}" *)
    (* ICP_CURRENT = "12", LPF_RESISTOR = "8" *)
    EHXPLLL #(
        .PLLRST_ENA("DISABLED"),
        .INTFB_WAKE("DISABLED"),
        .STDBY_ENABLE("DISABLED"),
        .DPHASE_SOURCE("DISABLED"),
        .FEEDBK_PATH("CLKOP"),
        .CLKI_DIV({{ page.pll.input }}),
        .CLKFB_DIV({{ page.pll.feedback }}),
        .CLKOP_ENABLE("ENABLED"),
        .OUTDIVIDER_MUXA("DIVA"),
        .CLKOP_DIV({{ page.pll.output }}),
        .CLKOP_CPHASE({{ page.pll.output - 1 }}),
        .CLKOP_FPHASE(0)
    ) pll (
        .CLKI(clock),
        .CLKFB(aclk),
        .CLKOP(aclk),
        .RST(1'b0),
        .STDBY(1'b0),
        .PHASESEL0(1'b0),
        .PHASESEL1(1'b0),
        .PHASEDIR(1'b1),
        .PHASESTEP(1'b1),
        .PHASELOADREG(1'b1),
        .PLLWAKESYNC(1'b0),
        .ENCLKOP(1'b0),
        .LOCK(locked)
    );
{% include "board/reset_and_board.v" %}

endmodule

`default_nettype wire
