// second_difference
// y = a - 2 b + c, one clock later.
//
// Written by subdiv-rtl VERSION; do not edit, generate it again:
//   the command
//   width = 8
// A comment behind a declaration states its format (s: signed, u: unsigned, Q integer.fraction bits)
// and its exact range; "mod 2^n" is a number known up to multiples of 2^n.

`default_nettype none

module second_difference (
    input  wire                aclk, // rising edge
    input  wire signed   [7:0] a,    // sQ4.4 [-128, 127]
    input  wire signed   [7:0] b,    // sQ4.4 [-128, 127]
    input  wire signed   [7:0] c,    // sQ4.4 [-128, 127]
    output reg  signed   [9:0] y     // sQ6.4 [-510, 510]
);

    // ---- clock 0 ------------------------------------------------------------
    always @(posedge aclk) begin
        y <= {{2{a[7]}}, a} - {b[7], b, 1'd0} + {{2{c[7]}}, c};
    end

endmodule

`default_nettype wire
