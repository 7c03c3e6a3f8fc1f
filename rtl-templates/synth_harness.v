// {{ name }}
// Holds {{ core }} for place and route: every input of the core comes from a register of a shift
// chain, every output ends in a register and is folded into one bit, so that nothing is trimmed and
// the pins do not limit. It computes nothing.

`default_nettype none

module {{ name }} (
    input  wire clock,
    input  wire reset_n,
    input  wire shift_in,
    output wire data_out
);

    reg  reset_held;
    // Between two inputs stands a register that is read by the next one alone: they may lie far apart.
    reg  [{{ inputs - 1 }}:0] chain;
    reg  [{{ inputs - 1 }}:0] between;
    wire [{{ outputs - 1 }}:0] outputs;

    always @(posedge clock) begin
        reset_held <= reset_n;
{%- if inputs > 1 %}
        between <= {chain[{{ inputs - 2 }}:0], shift_in};
{%- else %}
        between <= shift_in;
{%- endif %}
        chain <= between;
    end

    (* keep_hierarchy *)
    {{ core }} core (
{%- for connection in connections %}
        {{ connection }}{% if !loop.last %},{% endif %}
{%- endfor %}
    );
{% for stage in stages %}
    reg  [{{ stage.width - 1 }}:0] {{ stage.name }};
{%- endfor %}

    always @(posedge clock) begin
{%- for line in lines %}
        {{ line }}
{%- endfor %}
    end

    assign data_out = {{ last }};

endmodule
