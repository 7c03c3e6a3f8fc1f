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

    rPLL #(
        .FCLKIN("{{ page.oscillator }}"),
        .IDIV_SEL({{ page.pll.input - 1 }}),
        .FBDIV_SEL({{ page.pll.feedback - 1 }}),
        .ODIV_SEL({{ page.pll.output }}),
        .CLKFB_SEL("internal"),
        .DEVICE("GW2AR-18C")
    ) pll (
        .CLKIN(clock),
        .CLKFB(1'b0),
        .RESET(1'b0),
        .RESET_P(1'b0),
        .FBDSEL(6'b0),
        .IDSEL(6'b0),
        .ODSEL(6'b0),
        .PSDA(4'b0),
        .DUTYDA(4'b0),
        .FDLY(4'b0),
        .CLKOUT(aclk),
        .LOCK(locked)
    );
{% include "board/reset_and_board.v" %}

endmodule

`default_nettype wire
