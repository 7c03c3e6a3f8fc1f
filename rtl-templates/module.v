// {{ name }}
{%- for line in purpose %}
// {{ line }}
{%- endfor %}
//
// Written by subdiv-rtl {{ version }}; do not edit, generate it again:
//   {{ command }}
{%- for (parameter, value) in parameters %}
//   {{ parameter }} = {{ value }}
{%- endfor %}
// A comment behind a declaration states its format (s: signed, u: unsigned, Q integer.fraction bits)
// and its exact range; "mod 2^n" is a number known up to multiples of 2^n.

`default_nettype none

{% if separate %}(* keep_hierarchy *)
{% endif %}module {{ name }} (
{%- for port in ports %}
    {{ port }}
{%- endfor %}
);
{%- for section in sections %}

    // {{ section.banner }}
{%- for line in section.lines %}
{% if !line.is_empty() %}    {{ line }}{% endif %}
{%- endfor %}
{%- endfor %}

endmodule

`default_nettype wire
