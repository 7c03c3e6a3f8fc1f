// The models that do not come with Yosys: multipliers as it uses them, without registers, and a block RAM.
//
// Behind their sign, words of any kind are signed, so that one signed product serves all of them.

module MULT18X18D (
    input A17, A16, A15, A14, A13, A12, A11, A10, A9, A8, A7, A6, A5, A4, A3, A2, A1, A0,
    input B17, B16, B15, B14, B13, B12, B11, B10, B9, B8, B7, B6, B5, B4, B3, B2, B1, B0,
    input C17, C16, C15, C14, C13, C12, C11, C10, C9, C8, C7, C6, C5, C4, C3, C2, C1, C0,
    input SIGNEDA, SIGNEDB, SOURCEA, SOURCEB,
    output P35, P34, P33, P32, P31, P30, P29, P28, P27, P26, P25, P24, P23, P22, P21, P20, P19, P18, P17,
    P16, P15, P14, P13, P12, P11, P10, P9, P8, P7, P6, P5, P4, P3, P2, P1, P0
);
    wire signed [18:0] a = {SIGNEDA & A17,
        A17, A16, A15, A14, A13, A12, A11, A10, A9, A8, A7, A6, A5, A4, A3, A2, A1, A0};
    wire signed [18:0] b = {SIGNEDB & B17,
        B17, B16, B15, B14, B13, B12, B11, B10, B9, B8, B7, B6, B5, B4, B3, B2, B1, B0};
    wire signed [37:0] p = a * b;
    assign {
        P35, P34, P33, P32, P31, P30, P29, P28, P27, P26, P25, P24, P23, P22, P21, P20, P19, P18, P17, P16,
        P15, P14, P13, P12, P11, P10, P9, P8, P7, P6, P5, P4, P3, P2, P1, P0
    } = p[35:0];
endmodule

module MULT9X9 (
    input  CLK, CE, RESET, ASIGN, BSIGN, ASEL, BSEL,
    input  [8:0] A, B, SIA, SIB,
    output [17:0] DOUT
);
    wire signed [9:0] a = {ASIGN & A[8], A};
    wire signed [9:0] b = {BSIGN & B[8], B};
    wire signed [19:0] p = a * b;
    assign DOUT = p[17:0];
endmodule

module MULT18X18 (
    input  CLK, CE, RESET, ASIGN, BSIGN, ASEL, BSEL,
    input  [17:0] A, B, SIA, SIB,
    output [35:0] DOUT
);
    wire signed [18:0] a = {ASIGN & A[17], A};
    wire signed [18:0] b = {BSIGN & B[17], B};
    wire signed [37:0] p = a * b;
    assign DOUT = p[35:0];
endmodule

module MULT36X36 (
    input  CLK, CE, RESET, ASIGN, BSIGN,
    input  [35:0] A, B,
    output [71:0] DOUT
);
    wire signed [36:0] a = {ASIGN & A[35], A};
    wire signed [36:0] b = {BSIGN & B[35], B};
    wire signed [73:0] p = a * b;
    assign DOUT = p[71:0];
endmodule

// A block RAM of 1,024 rows of 18 bits as Yosys uses it: both ports of up to 18 bits, or writes at A and reads at B of up
// to 36; synchronous resets, rising clocks, and a second register at an output where REGMODE says OUTREG. Words of less
// than 9 bits leave every ninth bit out.
module DP16KD #(
    parameter DATA_WIDTH_A = 18, DATA_WIDTH_B = 18,
    parameter REGMODE_A = "NOREG", REGMODE_B = "NOREG",
    parameter WRITEMODE_A = "NORMAL", WRITEMODE_B = "NORMAL",
    parameter RESETMODE = "SYNC", ASYNC_RESET_RELEASE = "SYNC", GSR = "AUTO",
    parameter CSDECODE_A = "0b000", CSDECODE_B = "0b000", CLKAMUX = "CLKA", CLKBMUX = "CLKB",
    parameter [319:0]
    INITVAL_00 = 320'h0, INITVAL_01 = 320'h0, INITVAL_02 = 320'h0, INITVAL_03 = 320'h0, INITVAL_04 = 320'h0,
    INITVAL_05 = 320'h0, INITVAL_06 = 320'h0, INITVAL_07 = 320'h0, INITVAL_08 = 320'h0, INITVAL_09 = 320'h0,
    INITVAL_0A = 320'h0, INITVAL_0B = 320'h0, INITVAL_0C = 320'h0, INITVAL_0D = 320'h0, INITVAL_0E = 320'h0,
    INITVAL_0F = 320'h0, INITVAL_10 = 320'h0, INITVAL_11 = 320'h0, INITVAL_12 = 320'h0, INITVAL_13 = 320'h0,
    INITVAL_14 = 320'h0, INITVAL_15 = 320'h0, INITVAL_16 = 320'h0, INITVAL_17 = 320'h0, INITVAL_18 = 320'h0,
    INITVAL_19 = 320'h0, INITVAL_1A = 320'h0, INITVAL_1B = 320'h0, INITVAL_1C = 320'h0, INITVAL_1D = 320'h0,
    INITVAL_1E = 320'h0, INITVAL_1F = 320'h0, INITVAL_20 = 320'h0, INITVAL_21 = 320'h0, INITVAL_22 = 320'h0,
    INITVAL_23 = 320'h0, INITVAL_24 = 320'h0, INITVAL_25 = 320'h0, INITVAL_26 = 320'h0, INITVAL_27 = 320'h0,
    INITVAL_28 = 320'h0, INITVAL_29 = 320'h0, INITVAL_2A = 320'h0, INITVAL_2B = 320'h0, INITVAL_2C = 320'h0,
    INITVAL_2D = 320'h0, INITVAL_2E = 320'h0, INITVAL_2F = 320'h0, INITVAL_30 = 320'h0, INITVAL_31 = 320'h0,
    INITVAL_32 = 320'h0, INITVAL_33 = 320'h0, INITVAL_34 = 320'h0, INITVAL_35 = 320'h0, INITVAL_36 = 320'h0,
    INITVAL_37 = 320'h0, INITVAL_38 = 320'h0, INITVAL_39 = 320'h0, INITVAL_3A = 320'h0, INITVAL_3B = 320'h0,
    INITVAL_3C = 320'h0, INITVAL_3D = 320'h0, INITVAL_3E = 320'h0, INITVAL_3F = 320'h0
) (
    input CLKA, WEA, CEA, OCEA, RSTA, CSA0, CSA1, CSA2,
    input ADA13, ADA12, ADA11, ADA10, ADA9, ADA8, ADA7, ADA6, ADA5, ADA4, ADA3, ADA2, ADA1, ADA0,
    input DIA17, DIA16, DIA15, DIA14, DIA13, DIA12, DIA11, DIA10, DIA9, DIA8, DIA7, DIA6, DIA5, DIA4, DIA3,
    DIA2, DIA1, DIA0,
    output DOA17, DOA16, DOA15, DOA14, DOA13, DOA12, DOA11, DOA10, DOA9, DOA8, DOA7, DOA6, DOA5, DOA4, DOA3,
    DOA2, DOA1, DOA0,
    input CLKB, WEB, CEB, OCEB, RSTB, CSB0, CSB1, CSB2,
    input ADB13, ADB12, ADB11, ADB10, ADB9, ADB8, ADB7, ADB6, ADB5, ADB4, ADB3, ADB2, ADB1, ADB0,
    input DIB17, DIB16, DIB15, DIB14, DIB13, DIB12, DIB11, DIB10, DIB9, DIB8, DIB7, DIB6, DIB5, DIB4, DIB3,
    DIB2, DIB1, DIB0,
    output DOB17, DOB16, DOB15, DOB14, DOB13, DOB12, DOB11, DOB10, DOB9, DOB8, DOB7, DOB6, DOB5, DOB4, DOB3,
    DOB2, DOB1, DOB0
);
    localparam [20479:0] INIT = {
        INITVAL_3F, INITVAL_3E, INITVAL_3D, INITVAL_3C, INITVAL_3B, INITVAL_3A, INITVAL_39, INITVAL_38,
        INITVAL_37, INITVAL_36, INITVAL_35, INITVAL_34, INITVAL_33, INITVAL_32, INITVAL_31, INITVAL_30,
        INITVAL_2F, INITVAL_2E, INITVAL_2D, INITVAL_2C, INITVAL_2B, INITVAL_2A, INITVAL_29, INITVAL_28,
        INITVAL_27, INITVAL_26, INITVAL_25, INITVAL_24, INITVAL_23, INITVAL_22, INITVAL_21, INITVAL_20,
        INITVAL_1F, INITVAL_1E, INITVAL_1D, INITVAL_1C, INITVAL_1B, INITVAL_1A, INITVAL_19, INITVAL_18,
        INITVAL_17, INITVAL_16, INITVAL_15, INITVAL_14, INITVAL_13, INITVAL_12, INITVAL_11, INITVAL_10,
        INITVAL_0F, INITVAL_0E, INITVAL_0D, INITVAL_0C, INITVAL_0B, INITVAL_0A, INITVAL_09, INITVAL_08,
        INITVAL_07, INITVAL_06, INITVAL_05, INITVAL_04, INITVAL_03, INITVAL_02, INITVAL_01, INITVAL_00
    };
    reg [17:0] rows [0:1023];
    integer row;
    initial for (row = 0; row < 1024; row = row + 1) rows[row] = INIT[20 * row +: 18];

    wire [13:0] address_a = {ADA13, ADA12, ADA11, ADA10, ADA9, ADA8, ADA7, ADA6, ADA5, ADA4, ADA3, ADA2, ADA1,
    ADA0};
    wire [13:0] address_b = {ADB13, ADB12, ADB11, ADB10, ADB9, ADB8, ADB7, ADB6, ADB5, ADB4, ADB3, ADB2, ADB1,
    ADB0};
    wire [35:0] data_a = {DIB17, DIB16, DIB15, DIB14, DIB13, DIB12, DIB11, DIB10, DIB9, DIB8, DIB7, DIB6,
    DIB5, DIB4, DIB3, DIB2, DIB1, DIB0, DIA17, DIA16, DIA15, DIA14, DIA13, DIA12, DIA11, DIA10, DIA9, DIA8,
    DIA7, DIA6, DIA5, DIA4, DIA3, DIA2, DIA1, DIA0};
    wire [17:0] data_b = {DIB17, DIB16, DIB15, DIB14, DIB13, DIB12, DIB11, DIB10, DIB9, DIB8, DIB7, DIB6,
    DIB5, DIB4, DIB3, DIB2, DIB1, DIB0};

    // A word within two rows: where it is, and which bits are written.
    function [5:0] place(input integer width, input [13:0] address);
        case (width)
            36: place = 0;
            18: place = 18 * address[4];
            9: place = 18 * address[4] + 9 * address[3];
            4: place = 18 * address[4] + 9 * address[3] + 4 * address[2];
            2: place = 18 * address[4] + 9 * address[3] + 2 * address[2:1];
            default: place = 18 * address[4] + 9 * address[3] + 1 * address[2:0];
        endcase
    endfunction
    function [35:0] mask(input integer width, input [13:0] address);
        case (width)
            36: mask = {{9{address[3]}}, {9{address[2]}}, {9{address[1]}}, {9{address[0]}}};
            18: mask = {18'b0, {9{address[1]}}, {9{address[0]}}};
            9: mask = 36'h1ff;
            4: mask = 36'hf;
            2: mask = 36'h3;
            default: mask = 36'h1;
        endcase
    endfunction

    wire [35:0] old_a = {rows[{address_a[13:5], 1'b1}], rows[{address_a[13:5], 1'b0}]};
    wire [5:0] place_a = place(DATA_WIDTH_A, address_a);
    wire [35:0] mask_a = mask(DATA_WIDTH_A, address_a) << place_a;
    wire [35:0] new_a = (old_a & ~mask_a) | ((data_a << place_a) & mask_a);
    reg [35:0] read_a, kept_a;
    initial {read_a, kept_a} = 72'h0;
    always @(posedge CLKA) begin
        if (RSTA) read_a <= 36'h0;
        else if (CEA && !(WEA && WRITEMODE_A == "NORMAL"))
            read_a <= (WEA && WRITEMODE_A == "WRITETHROUGH" ? new_a : old_a) >> place_a;
        if (RSTA) kept_a <= 36'h0;
        else if (OCEA) kept_a <= read_a;
        if (CEA && WEA) begin
            rows[{address_a[13:5], 1'b1}] <= new_a[35:18];
            rows[{address_a[13:5], 1'b0}] <= new_a[17:0];
        end
    end

    wire [35:0] old_b = {rows[{address_b[13:5], 1'b1}], rows[{address_b[13:5], 1'b0}]};
    wire [5:0] place_b = place(DATA_WIDTH_B, address_b);
    wire [35:0] mask_b = mask(DATA_WIDTH_B, address_b) << place_b;
    wire [35:0] new_b = (old_b & ~mask_b) | (({18'b0, data_b} << place_b) & mask_b);
    reg [35:0] read_b, kept_b;
    initial {read_b, kept_b} = 72'h0;
    always @(posedge CLKB) begin
        if (RSTB) read_b <= 36'h0;
        else if (CEB && !(WEB && WRITEMODE_B == "NORMAL"))
            read_b <= (WEB && WRITEMODE_B == "WRITETHROUGH" ? new_b : old_b) >> place_b;
        if (RSTB) kept_b <= 36'h0;
        else if (OCEB) kept_b <= read_b;
        if (CEB && WEB) begin
            rows[{address_b[13:5], 1'b1}] <= new_b[35:18];
            rows[{address_b[13:5], 1'b0}] <= new_b[17:0];
        end
    end

    wire [35:0] out_a = REGMODE_A == "OUTREG" ? kept_a : read_a;
    wire [35:0] out_b = REGMODE_B == "OUTREG" ? kept_b : read_b;
    wire wide = DATA_WIDTH_B == 36;
    assign {DOA17, DOA16, DOA15, DOA14, DOA13, DOA12, DOA11, DOA10, DOA9, DOA8, DOA7, DOA6, DOA5, DOA4, DOA3,
    DOA2, DOA1, DOA0} = wide ? out_b[17:0] : out_a[17:0];
    assign {DOB17, DOB16, DOB15, DOB14, DOB13, DOB12, DOB11, DOB10, DOB9, DOB8, DOB7, DOB6, DOB5, DOB4, DOB3,
    DOB2, DOB1, DOB0} = wide ? out_b[35:18] : out_b[17:0];
endmodule
