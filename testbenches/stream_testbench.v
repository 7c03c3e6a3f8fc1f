// Testbench {{ bench.name }}: drives {{ bench.top }} with vectors and checks all that comes out.
//
// Reads   input.hex      one beat a line: {{ bench.input.columns() }}
//         expected.hex   one beat a line: {{ bench.output.columns() }}
//         stalls.hex     one digit a clock, 4096 of them, used in turn: bit 0 offers an input beat,
//                        bit 1 is m_axis_tready; without this file nothing stalls
// Writes  received.hex   the clock and the beat, one line for each beat taken
//         PASS or FAIL as its last word, and before it what is wrong and where
//
// Options +clocks=HEX    the number of clocks it must take (not checked unless given)
//         +patience=HEX  clocks without a transfer after which the core counts as hanging
//         +vcd_from=HEX +vcd_to=HEX   write window.vcd of these clocks, then stop
//
// Clock 0 is the first one after the release of reset.
// A clock takes 10 time units; there is no timescale because synthesizable modules have none either.

`default_nettype none

module {{ bench.name }};

    // ---------------------------------------------------------------- the device under test

    reg aclk;
    reg aresetn;
{%- for signal in bench.input.signals %}
    reg {{ signal.range }}s_axis_{{ signal.name }};
{%- endfor %}
    reg s_axis_tvalid;
    wire s_axis_tready;
{%- for signal in bench.output.signals %}
    wire {{ signal.range }}m_axis_{{ signal.name }};
{%- endfor %}
    wire m_axis_tvalid;
    reg m_axis_tready;

    {{ bench.top }} dut (
        .aclk(aclk),
        .aresetn(aresetn),
{%- for signal in bench.input.signals %}
        .s_axis_{{ signal.name }}(s_axis_{{ signal.name }}),
{%- endfor %}
        .s_axis_tvalid(s_axis_tvalid),
        .s_axis_tready(s_axis_tready),
{%- for signal in bench.output.signals %}
        .m_axis_{{ signal.name }}(m_axis_{{ signal.name }}),
{%- endfor %}
        .m_axis_tvalid(m_axis_tvalid),
        .m_axis_tready(m_axis_tready)
    );

    // ---------------------------------------------------------------- vectors and stalls

    integer input_file;
    integer expected_file;
    integer received_file;
    integer stalls_file;
    integer fields;

    reg [1:0] stalls [0:4095];
    integer at;

    // The next beat to offer, and whether there is one.
    reg have_input;
    reg offering;
{%- for signal in bench.input.signals %}
    reg {{ signal.range }}input_{{ signal.name }};
{%- endfor %}
{%- for part in bench.input.parts() %}
    reg {{ part.range }}input_{{ part.name }};
{%- endfor %}

    // The next beat to come out, and whether there is one.
    reg have_expected;
{%- for signal in bench.output.signals %}
    reg {{ signal.range }}expected_{{ signal.name }};
{%- endfor %}
{%- for part in bench.output.parts() %}
    reg {{ part.range }}expected_{{ part.name }};
{%- endfor %}

    task read_input;
        begin
            fields = $fscanf(input_file, "{{ bench.input.format() }}"{{ bench.input.scanned("input_") }});
{%- if bench.input.cut() %}
            input_tdata = {{ bench.input.joined("input_") }};
{%- endif %}
            have_input = fields == {{ bench.input.fields() }};
            if (fields > 0 && !have_input) fail_file;
        end
    endtask

    task read_expected;
        begin
            fields = $fscanf(expected_file, "{{ bench.output.format() }}"{{ bench.output.scanned("expected_") }});
{%- if bench.output.cut() %}
            expected_tdata = {{ bench.output.joined("expected_") }};
{%- endif %}
            have_expected = fields == {{ bench.output.fields() }};
            if (fields > 0 && !have_expected) fail_file;
        end
    endtask

    // ---------------------------------------------------------------- what was seen

    reg running;
    reg [63:0] clock;
    reg [63:0] quiet;        // clocks since the last transfer
    reg [63:0] drained;      // clocks since everything is in and out
    reg [63:0] accepted;     // input beats taken by the core
    reg [63:0] received;     // output beats taken by the testbench
    reg [63:0] clocks;       // from reset to the last output beat
    reg [63:0] failures;
    reg [63:0] mismatches;
    reg unstable_seen;
    reg unknown_seen;

    // The beat that stood at the output in the clock before and was not taken.
    reg held;
{%- for signal in bench.output.signals %}
    reg {{ signal.range }}held_{{ signal.name }};
{%- endfor %}

    reg stalled;             // whether any stall happened before the first output
    reg first_seen;
    reg [63:0] first_clock;  // of the first valid output
    reg started;
    reg [63:0] start_clock;  // of the acceptance of input beat {{ bench.latency_beat }}
    reg signed [63:0] latency;

    reg [63:0] expected_clocks;
    reg check_clocks;
    reg [63:0] patience;
    reg [63:0] vcd_from;
    reg [63:0] vcd_to;
    reg vcd;

    task fail_file;
        begin
            $display("broken: a vector file is missing or has a line that cannot be read");
            failures = failures + 1;
            running = 1'b0;
        end
    endtask

    // ---------------------------------------------------------------- the checks

    // A control signal must be 0 or 1; tvalid must stay and the beat must not change until taken.
    task check_protocol;
        begin
            if (s_axis_tready !== 1'b0 && s_axis_tready !== 1'b1) unknown("s_axis_tready");
            if (m_axis_tvalid !== 1'b0 && m_axis_tvalid !== 1'b1) unknown("m_axis_tvalid");
            if (held) begin
                if (m_axis_tvalid !== 1'b1) unstable("m_axis_tvalid");
{%- for signal in bench.output.signals %}
                else if (m_axis_{{ signal.name }} !== held_{{ signal.name }}) unstable("m_axis_{{ signal.name }}");
{%- endfor %}
            end
            held = m_axis_tvalid === 1'b1 && !m_axis_tready;
{%- for signal in bench.output.signals %}
            held_{{ signal.name }} = m_axis_{{ signal.name }};
{%- endfor %}
        end
    endtask

    task unstable(input [8 * 13 - 1:0] signal);
        begin
            if (!unstable_seen) begin
                $display("unstable: signal=%0s clock=%0d beat=%0d", signal, clock, received);
                failures = failures + 1;
            end
            unstable_seen = 1'b1;
        end
    endtask

    task unknown(input [8 * 13 - 1:0] signal);
        begin
            if (!unknown_seen) begin
                $display("unknown: signal=%0s clock=%0d beat=%0d", signal, clock, received);
                failures = failures + 1;
            end
            unknown_seen = 1'b1;
        end
    endtask

    reg differs;
{%- if bench.output.keep %}
    integer lane_byte;
    reg [7:0] got_byte;
{%- endif %}

    // Compares the beat at the output, byte by byte where tkeep says so.
    task check_beat;
        begin
            differs = 1'b0;
{%- for signal in bench.output.signals %}
{%- if signal.name == "tdata" && bench.output.keep %}
            if (m_axis_tdata !== expected_tdata)
                for (lane_byte = 0; lane_byte < {{ bench.output.keep_bits }}; lane_byte = lane_byte + 1)
                    if (expected_tkeep[lane_byte]) begin
                        got_byte = m_axis_tdata[8 * lane_byte +: 8];
                        if (got_byte !== expected_tdata[8 * lane_byte +: 8]) differs = 1'b1;
                        if (^got_byte !== 1'b0 && ^got_byte !== 1'b1) unknown("m_axis_tdata");
                    end
{%- else %}
            if (m_axis_{{ signal.name }} !== expected_{{ signal.name }}) differs = 1'b1;
            if (^m_axis_{{ signal.name }} !== 1'b0 && ^m_axis_{{ signal.name }} !== 1'b1) unknown("m_axis_{{ signal.name }}");
{%- endif %}
{%- endfor %}
            if (differs) begin
                if (mismatches == 0) begin
                    $display("mismatch: beat=%0d clock=%0d", received, clock);
                    $display("  expected {{ bench.output.format() }}"{{ bench.output.arguments("expected_") }});
                    $display("  got      {{ bench.output.format() }}"{{ bench.output.arguments("m_axis_") }});
                    failures = failures + 1;
                end
                mismatches = mismatches + 1;
            end
        end
    endtask

    task take_output;
        begin
            $fwrite(received_file, "%h {{ bench.output.format() }}\n", clock{{ bench.output.arguments("m_axis_") }});
            check_beat;
            received = received + 1;
            clocks = clock + 1;
            quiet = 0;
            read_expected;
        end
    endtask

    task take_input;
        begin
            if (accepted == {{ bench.latency_beat }}) begin
                started = 1'b1;
                start_clock = clock;
            end
            accepted = accepted + 1;
            offering = 1'b0;
            quiet = 0;
            read_input;
        end
    endtask

    // After the end: the figures, and the checks that concern the whole run.
    task conclude;
        begin
            if (first_seen && started) begin
                latency = $signed(first_clock) - $signed(start_clock);
{%- if let Some(clocks) = bench.latency_clocks %}
                if (!stalled && latency != {{ clocks }}) begin
                    $display("latency: expected={{ clocks }} measured=%0d clock=%0d", latency, first_clock);
                    failures = failures + 1;
                end
{%- endif %}
            end
            if (failures == 0 && check_clocks && clocks != expected_clocks) begin
                $display("clocks: expected=%0d measured=%0d", expected_clocks, clocks);
                failures = failures + 1;
            end
            $display("total: beats=%0d clocks=%0d mismatches=%0d accepted=%0d",
                     received, clocks, mismatches, accepted);
            if (first_seen && started) $display("measured: latency=%0d stalled=%0d", latency, stalled);
            if (failures == 0) $display("PASS");
            else $display("FAIL");
        end
    endtask

    // ---------------------------------------------------------------- the run

    initial begin : run
        running = 1'b1;
        clock = 0;
        quiet = 0;
        drained = 0;
        accepted = 0;
        received = 0;
        clocks = 0;
        failures = 0;
        mismatches = 0;
        unstable_seen = 1'b0;
        unknown_seen = 1'b0;
        held = 1'b0;
        stalled = 1'b0;
        first_seen = 1'b0;
        first_clock = 0;
        started = 1'b0;
        start_clock = 0;
        latency = 0;
        offering = 1'b0;
        have_input = 1'b0;
        have_expected = 1'b0;
        check_clocks = $value$plusargs("clocks=%h", expected_clocks) != 0;
        if ($value$plusargs("patience=%h", patience) == 0) patience = 20000;
        vcd = $value$plusargs("vcd_from=%h", vcd_from) != 0;
        if ($value$plusargs("vcd_to=%h", vcd_to) == 0) vcd_to = ~64'd0;

        input_file = $fopen("input.hex", "r");
        expected_file = $fopen("expected.hex", "r");
        received_file = $fopen("received.hex", "w");
        stalls_file = $fopen("stalls.hex", "r");
        for (at = 0; at < 4096; at = at + 1) stalls[at] = 2'b11;
        if (stalls_file != 0) $readmemh("stalls.hex", stalls);
        if (input_file == 0 || expected_file == 0 || received_file == 0) fail_file;
        else begin
            read_input;
            read_expected;
        end

        aclk = 1'b0;
        aresetn = 1'b0;
        s_axis_tvalid = 1'b0;
        m_axis_tready = 1'b0;
{%- for signal in bench.input.signals %}
        s_axis_{{ signal.name }} = {{ signal.width }}'d0;
{%- endfor %}
        for (at = 0; at < {{ bench.reset_clocks }}; at = at + 1) begin
            #5 aclk = 1'b1;
            #5 aclk = 1'b0;
        end
        aresetn = 1'b1;

        while (running) begin
            // Drive while the clock is low; a beat once offered stays until it is accepted. While
            // nothing is offered the payload is wrong on purpose.
            if (have_input && !offering) offering = stalls[clock[11:0]][0];
            s_axis_tvalid = offering;
{%- for signal in bench.input.signals %}
            s_axis_{{ signal.name }} = offering ? input_{{ signal.name }} : ~input_{{ signal.name }};
{%- endfor %}
            m_axis_tready = stalls[clock[11:0]][1];
            if (vcd && clock == vcd_from) begin
                $dumpfile("window.vcd");
                $dumpvars(0, {{ bench.name }});
            end
            #5;

            // Look when all is settled, just before the edge.
            quiet = quiet + 1;
            check_protocol;
            if (!first_seen) begin
                if (!m_axis_tready || (have_input && !offering)) stalled = 1'b1;
                if (m_axis_tvalid === 1'b1) begin
                    first_seen = 1'b1;
                    first_clock = clock;
                end
            end
            if (m_axis_tvalid === 1'b1 && !have_expected) begin
                $display("extra: clock=%0d beat=%0d", clock, received);
                failures = failures + 1;
                running = 1'b0;
            end
            else if (m_axis_tvalid === 1'b1 && m_axis_tready) take_output;
            if (s_axis_tvalid && s_axis_tready === 1'b1) take_input;

            if (!have_input && !have_expected) begin
                drained = drained + 1;
                if (drained > {{ bench.drain_clocks }}) running = 1'b0;
            end
            else if (quiet >= patience) begin
                $display("hang: clock=%0d beat=%0d accepted=%0d quiet=%0d", clock, received, accepted, quiet);
                failures = failures + 1;
                running = 1'b0;
            end
            if (vcd && clock == vcd_to) running = 1'b0;

            aclk = 1'b1;
            #5;
            aclk = 1'b0;
            clock = clock + 1;
        end

        $fclose(received_file);
        conclude;
        $finish;
    end

endmodule

`default_nettype wire
