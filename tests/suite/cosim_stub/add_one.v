// A stream core for the tests of co-simulation: adds one to each of three lanes, two stages deep.
// The tuser of the first input beat chooses what is broken, so that one build serves all tests.

`default_nettype none

module add_one (
    input wire aclk,
    input wire aresetn,
    input wire [71:0] s_axis_tdata,
    input wire [3:0] s_axis_tuser,
    input wire s_axis_tlast,
    input wire s_axis_tvalid,
    output wire s_axis_tready,
    output wire [71:0] m_axis_tdata,
    output wire [8:0] m_axis_tkeep,
    output wire [1:0] m_axis_tuser,
    output wire m_axis_tlast,
    output wire m_axis_tvalid,
    input wire m_axis_tready
);
    localparam WRONG_BIT = 4'd1;
    localparam DROPS = 4'd2;
    localparam REPEATS = 4'd3;
    localparam CHANGES = 4'd4;
    localparam FALLS = 4'd5;
    localparam LOSES_CLOCKS = 4'd6;
    localparam WRONG_LAST = 4'd7;
    localparam WRONG_USER = 4'd8;
    localparam WRONG_KEEP = 4'd9;
    localparam HANGS = 4'd10;
    localparam EXTRA = 4'd11;
    localparam LATE = 4'd12;

    reg [3:0] fault;
    reg [7:0] taken;
    reg [2:0] phase;
    reg first;
    reg delayed;
    reg waited;
    reg repeated;

    reg a_valid;
    reg [71:0] a_data;
    reg a_first;
    reg a_last;
    reg [7:0] a_index;

    reg b_valid;
    reg [71:0] b_data;
    reg b_first;
    reg b_last;
    reg [7:0] b_index;

    wire again = !repeated
        && ((fault == REPEATS && b_index == 8'd6) || (fault == EXTRA && b_index == 8'd11));
    wire transfer = m_axis_tvalid && m_axis_tready;
    wire b_free = !b_valid || (transfer && !again);
    wire a_go = b_free && !(fault == LATE && a_valid && !delayed);
    wire accept = s_axis_tvalid && s_axis_tready;

    assign s_axis_tready = (!a_valid || a_go)
        && !(fault == LOSES_CLOCKS && phase == 3'd5)
        && !(fault == HANGS && taken == 8'd7);
    assign m_axis_tvalid = b_valid && !(fault == FALLS && waited);
    assign m_axis_tdata = b_data
        ^ (fault == WRONG_BIT && b_index == 8'd5 ? 72'h200000000 : 72'd0)
        ^ (fault == CHANGES && waited ? 72'h10000000000 : 72'd0);
    assign m_axis_tkeep = b_last && fault != WRONG_KEEP ? 9'h007 : 9'h1ff;
    assign m_axis_tuser = {b_last, b_first && !(fault == WRONG_USER && b_index == 8'd4)};
    assign m_axis_tlast = b_last || (fault == WRONG_LAST && b_index == 8'd6);

    always @(posedge aclk)
        if (!aresetn) begin
            fault <= 4'd0;
            taken <= 8'd0;
            phase <= 3'd0;
            first <= 1'b1;
            delayed <= 1'b0;
            waited <= 1'b0;
            repeated <= 1'b0;
            a_valid <= 1'b0;
            b_valid <= 1'b0;
        end
        else begin
            phase <= phase + 3'd1;
            waited <= m_axis_tvalid && !m_axis_tready;
            if (transfer && again) repeated <= 1'b1;
            if (a_valid) delayed <= 1'b1;
            if (accept) begin
                if (taken == 8'd0) fault <= s_axis_tuser;
                taken <= taken == 8'hff ? 8'hfe : taken + 8'd1;
                first <= s_axis_tlast;
            end
            if (!a_valid || a_go) begin
                a_valid <= accept && !(fault == DROPS && taken == 8'd5);
                a_data <= {s_axis_tdata[71:48] + 24'd1, s_axis_tdata[47:24] + 24'd1, s_axis_tdata[23:0] + 24'd1};
                a_first <= first;
                a_last <= s_axis_tlast;
                a_index <= taken;
            end
            if (a_go) begin
                b_valid <= a_valid;
                b_data <= a_data;
                b_first <= a_first;
                b_last <= a_last;
                b_index <= a_index;
            end
            else if (transfer && !again) b_valid <= 1'b0;
        end

endmodule

`default_nettype wire
