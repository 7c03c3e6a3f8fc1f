// Testbench board_testbench: a receiver at the serial line of mesh_board.
//
// Reads   simulation/expected.hex   the bytes of the frame
// Writes  build/received.hex        the bytes that came, of both frames
//         PASS or FAIL at the start of its last line
//
// The first frame comes after the reset, the second one after the button. Option +flip=HEX turns round the
// data bit of this number, counted from 0 over all bytes.
//
// Written by subdiv-rtl {{ page.version }}:
//   {{ page.command }}

`default_nettype none

module board_testbench;

    localparam integer CLOCKS_PER_BIT = {{ page.clocks_per_bit }};
    localparam integer BUTTON_CLOCKS = {{ page.button_clocks }};
    localparam integer BYTES = {{ page.bytes }};
    localparam integer PATIENCE = 1000 * CLOCKS_PER_BIT + BUTTON_CLOCKS;

    reg aclk;
    reg aresetn;
    reg button;
    wire led_busy;
    wire led_done;
    wire txd;

    mesh_board board (
        .aclk(aclk),
        .aresetn(aresetn),
        .button(button),
        .led_busy(led_busy),
        .led_done(led_done),
        .txd(txd)
    );

    initial aclk = 1'b0;
    always #5 aclk = !aclk;

    reg [7:0] expected [0:BYTES-1];
    reg [7:0] received_byte;
    reg [31:0] flip;
    reg has_flip;
    integer received_file;
    integer received;
    integer wrong;
    integer index;
    integer at;

    // A frame after the reset and one after the button.
    initial begin
        button = 1'b0;
        aresetn = 1'b0;
        repeat (8) @(negedge aclk);
        aresetn = 1'b1;
        wait (received == BYTES && !led_busy && led_done);
        @(negedge aclk) button = 1'b1;
        repeat (BUTTON_CLOCKS) @(negedge aclk);
        button = 1'b0;
    end

    // The receiver samples in the middle of each bit.
    initial begin
        received = 0;
        wrong = 0;
        at = 0;
        has_flip = $value$plusargs("flip=%h", flip) != 0;
        $readmemh("simulation/expected.hex", expected);
        received_file = $fopen("build/received.hex", "w");
        wait (aresetn);
        while (received < 2 * BYTES) begin
            @(negedge txd);
            repeat (CLOCKS_PER_BIT / 2) @(negedge aclk);
            if (!txd) begin
                for (index = 0; index < 8; index = index + 1) begin
                    repeat (CLOCKS_PER_BIT) @(negedge aclk);
                    received_byte[index] = txd ^ (has_flip && flip == 8 * received + index);
                end
                repeat (CLOCKS_PER_BIT) @(negedge aclk);
                if (!txd || received_byte !== expected[at]) begin
                    if (wrong == 0)
                        $display("byte %0d is %h, stop bit %b, expected %h", received, received_byte, txd, expected[at]);
                    wrong = wrong + 1;
                end
                $fdisplay(received_file, "%h", received_byte);
                at = at + 1 == BYTES ? 0 : at + 1;
                received = received + 1;
            end
        end
        repeat (50 * CLOCKS_PER_BIT) @(negedge aclk) if (!txd) wrong = wrong + 1;
        $fclose(received_file);
        if (wrong == 0) $display("PASS: two frames of %0d bytes", BYTES);
        else $display("FAIL: %0d wrong bytes", wrong);
        $finish;
    end

    // Nothing for a long time: the hardware hangs.
    integer seen;
    integer quiet;
    initial begin
        seen = 0;
        quiet = 0;
        while (quiet < PATIENCE) begin
            @(negedge aclk) quiet = received == seen ? quiet + 1 : 0;
            seen = received;
        end
        $display("FAIL: silence after %0d of %0d bytes", received, 2 * BYTES);
        $finish;
    end

endmodule

`default_nettype wire
