// {{ top }}, the inner modules first; for the option -f of Verilator, Icarus and others, in this folder.
// Written by subdiv-rtl {{ version }}: {{ command }}
{%- for file in sources %}
{{ file }}
{%- endfor %}
