
    // Out of reset sixteen clocks after the clock is there.
    reg [1:0] steady = 2'b00;
    reg [3:0] reset_clocks = 4'd0;
    wire aresetn = &reset_clocks;

    always @(posedge aclk) begin
        steady <= {steady[0], locked};
        if (!steady[1]) reset_clocks <= 4'd0;
        else if (!aresetn) reset_clocks <= reset_clocks + 4'd1;
    end

    wire busy;
    wire done;

    mesh_board board (
        .aclk(aclk),
        .aresetn(aresetn),
        .button({% if page.button_low %}!{% endif %}button),
        .led_busy(busy),
        .led_done(done),
        .txd(txd)
    );

    assign led_busy = {% if page.leds_low %}!{% endif %}busy;
    assign led_done = {% if page.leds_low %}!{% endif %}done;
{%- for (name, _) in page.pins.high %}
    assign {{ name }} = 1'b1;
{%- endfor %}
