# Evaluates a plan of design points, a job a shard, and merges the results.
#
#   snakemake --cores all                             on this machine
#   snakemake --jobs 20 --executor NAME               on a cluster, however Snakemake is set up for it
#
# Written by subdiv-rtl {{ version }}. A shard that was stopped goes on where it was.

PROGRAM = "{{ program }}"
PLAN = "{{ plan }}"
SHARDS = {{ shards }}
RESULT = "{{ output }}"


rule all:
    input:
        RESULT,


rule shard:
    input:
        PLAN,
    output:
        "{{ output }}.shards/{shard}.jsonl",
    wildcard_constraints:
        shard=r"\d+",
    threads: {{ threads }}
    shell:
        "{PROGRAM} --quiet explore run {input} --shard {wildcards.shard}/{SHARDS}"
        " --threads {threads}{% if synthesise %} --synth{% endif %} -o {output}.part"
        " && cp {output}.part {output}"


rule merge:
    input:
        plan=PLAN,
        shards=expand("{{ output }}.shards/{shard}.jsonl", shard=range(1, SHARDS + 1)),
    output:
        RESULT,
    shell:
        "{PROGRAM} explore merge {input.shards} --plan {input.plan} -o {output}"
