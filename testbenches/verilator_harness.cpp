// C++ harness of {{ bench.top }} for Verilator: the same files, options and checks as {{ bench.name }}.v,
// at the full speed of the compiled model.

#include "Vdut.h"
#include "verilated.h"
#if VM_TRACE
#include "verilated_vcd_c.h"
#endif
#if VM_COVERAGE
#include "verilated_cov.h"
#endif

#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <memory>
#include <string>
#include <vector>

namespace {

// ------------------------------------------------------------------ bits of any width

// A value is 32-bit words, least significant first, in Verilator's own order.
using Word = uint32_t;

constexpr size_t words(size_t bits) { return (bits + 31) / 32; }

template <typename Narrow> void put(Narrow& port, const Word* from) { port = static_cast<Narrow>(from[0]); }
[[maybe_unused]] void put(QData& port, const Word* from) { port = from[0] | static_cast<QData>(from[1]) << 32; }
template <size_t N> void put(VlWide<N>& port, const Word* from) {
    for (size_t i = 0; i < N; ++i) port[i] = from[i];
}

template <typename Narrow> void get(const Narrow& port, Word* to) { to[0] = port; }
[[maybe_unused]] void get(const QData& port, Word* to) {
    to[0] = static_cast<Word>(port);
    to[1] = static_cast<Word>(port >> 32);
}
template <size_t N> void get(const VlWide<N>& port, Word* to) {
    for (size_t i = 0; i < N; ++i) to[i] = port[i];
}

// One signal within a beat: its name, its width, its first word.
struct Signal {
    const char* name;
    size_t bits;
    size_t word;
};

{% for (kind, stream) in bench.streams() -%}
constexpr Signal {{ kind }}_signals[] = {
{%- for signal in stream.signals %}
    {"{{ signal.name }}", {{ signal.width }}, {{ signal.word }}},
{%- endfor %}
};
constexpr size_t {{ kind }}_words = {{ stream.words }};
{% endfor %}
// ------------------------------------------------------------------ vectors

// A field is so many bits at most; a wider tdata is cut, highest field first.
constexpr size_t field_bits = {{ bench.field_bits }};

std::string slurp(const char* name) {
    std::string text;
    if (FILE* file = std::fopen(name, "rb")) {
        char part[1 << 16];
        while (size_t count = std::fread(part, 1, sizeof part, file)) text.append(part, count);
        std::fclose(file);
    }
    return text;
}

int digit(char c) {
    if (c >= '0' && c <= '9') return c - '0';
    if (c >= 'a' && c <= 'f') return c - 'a' + 10;
    return -1;
}

// Reads one hexadecimal number into zeroed words; false if there is none or it is too long.
bool read_number(const char*& at, const char* end, Word* to, size_t bits) {
    while (at < end && (*at == ' ' || *at == '\n')) ++at;
    const char* start = at;
    while (at < end && digit(*at) >= 0) ++at;
    size_t count = at - start;
    if (count == 0 || count > 8 * words(bits)) return false;
    for (size_t i = 0; i < count; ++i) to[i / 8] |= static_cast<Word>(digit(at[-1 - static_cast<long>(i)])) << (i % 8 * 4);
    return true;
}

// All beats of a file, one after the other; the number of them, or -1 for a line that cannot be read.
template <size_t Count>
long read_beats(const char* name, const Signal (&signals)[Count], size_t beat_words, std::vector<Word>& beats) {
    const std::string text = slurp(name);
    const char* at = text.data();
    const char* end = at + text.size();
    long count = 0;
    while (at < end) {
        size_t base = beats.size();
        beats.resize(base + beat_words);
        for (const Signal& signal : signals)
            for (size_t field = (signal.bits + field_bits - 1) / field_bits; field-- > 0;) {
                size_t low = field * field_bits;
                size_t width = signal.bits - low < field_bits ? signal.bits - low : field_bits;
                if (!read_number(at, end, &beats[base + signal.word + low / 32], width)) return -1;
            }
        while (at < end && *at == '\n') ++at;
        ++count;
    }
    return count;
}

char* write_number(char* to, const Word* from, size_t bits) {
    for (size_t i = (bits + 3) / 4; i-- > 0;) *to++ = "0123456789abcdef"[from[i / 8] >> (i % 8 * 4) & 15];
    return to;
}

void write_beat(std::vector<char>& text, uint64_t clock, const Word* beat) {
    char line[{{ bench.output.line_characters() }}];
    const Word time[2] = {static_cast<Word>(clock), static_cast<Word>(clock >> 32)};
    char* to = write_number(line, time, 64);
    for (const Signal& signal : output_signals)
        for (size_t field = (signal.bits + field_bits - 1) / field_bits; field-- > 0;) {
            size_t low = field * field_bits;
            *to++ = ' ';
            to = write_number(to, beat + signal.word + low / 32, signal.bits - low < field_bits ? signal.bits - low : field_bits);
        }
    *to++ = '\n';
    text.insert(text.end(), line, to);
}

// ------------------------------------------------------------------ the checks

bool same(const Signal& signal, const Word* a, const Word* b) {
    return std::memcmp(a + signal.word, b + signal.word, 4 * words(signal.bits)) == 0;
}

// Whether the bytes of tdata that the expected tkeep keeps are equal.
[[maybe_unused]] bool same_kept(const Signal& data, const Signal& keep, const Word* expected, const Word* got) {
    for (size_t byte = 0; byte < keep.bits; ++byte) {
        if (!(expected[keep.word + byte / 32] >> (byte % 32) & 1)) continue;
        Word difference = expected[data.word + byte / 4] ^ got[data.word + byte / 4];
        if (difference >> (byte % 4 * 8) & 0xff) return false;
    }
    return true;
}

bool same_beat(const Word* expected, const Word* got) {
    if (std::memcmp(expected, got, 4 * output_words) == 0) return true;
{%- for signal in bench.output.signals %}
{%- if signal.name == "tdata" && bench.output.keep %}
    if (!same_kept(output_signals[{{ loop.index0 }}], output_signals[{{ loop.index0 - 1 }}], expected, got)) return false;
{%- else %}
    if (!same(output_signals[{{ loop.index0 }}], expected, got)) return false;
{%- endif %}
{%- endfor %}
    return true;
}

// The number behind "+name=" in hexadecimal.
bool option(int count, char** arguments, const char* name, uint64_t& value) {
    const std::string start = std::string("+") + name + "=";
    for (int i = 1; i < count; ++i)
        if (std::strncmp(arguments[i], start.c_str(), start.size()) == 0) {
            value = std::strtoull(arguments[i] + start.size(), nullptr, 16);
            return true;
        }
    return false;
}

}  // namespace

// ---------------------------------------------------------------------- the run

int main(int count, char** arguments) {
    using Number = unsigned long long;  // for printf
    uint64_t expected_clocks = 0, patience = 20000, vcd_from = 0, vcd_to = ~0ull;
    const bool check_clocks = option(count, arguments, "clocks", expected_clocks);
    option(count, arguments, "patience", patience);
    [[maybe_unused]] const bool vcd = option(count, arguments, "vcd_from", vcd_from);
    option(count, arguments, "vcd_to", vcd_to);

    std::vector<Word> input, expected;
    const long inputs = read_beats("input.hex", input_signals, input_words, input);
    const long expecteds = read_beats("expected.hex", output_signals, output_words, expected);
    const std::string stalls_text = slurp("stalls.hex");
    std::vector<unsigned> stalls;
    for (char c : stalls_text)
        if (digit(c) >= 0) stalls.push_back(digit(c));
    stalls.resize(4096, 3);
    if (inputs < 0 || expecteds < 0) {
        std::puts("broken: a vector file has a line that cannot be read\nFAIL");
        return 0;
    }

    auto context = std::make_unique<VerilatedContext>();
    // Registers that reset forgets start with bits that are not zero, the same ones in every run.
    // Not for coverage: there these bits would toggle at reset and count as reached.
    context->randReset(VM_COVERAGE ? 0 : 2);
    context->randSeed(1);
#if VM_TRACE
    context->traceEverOn(true);
#endif
    auto dut = std::make_unique<Vdut>(context.get());
#if VM_TRACE
    VerilatedVcdC wave;
    dut->trace(&wave, 99);
#endif

    uint64_t clock = 0, quiet = 0, drained = 0, failures = 0, mismatches = 0, clocks = 0;
    long accepted = 0, received = 0;
    bool running = true, offering = false, held = false, unstable = false;
    bool stalled = false, first_seen = false, started = false;
    uint64_t first_clock = 0, start_clock = 0;
    Word got[output_words] = {}, previous[output_words] = {};
    Word inverted[input_words] = {};
    std::vector<char> received_text;
    received_text.reserve((expecteds + 1) * sizeof(Word) * 4 * output_words);

    dut->aclk = 0;
    dut->aresetn = 0;
    dut->s_axis_tvalid = 0;
    dut->m_axis_tready = 0;
{%- for signal in bench.input.signals %}
    put(dut->s_axis_{{ signal.name }}, inverted + {{ signal.word }});
{%- endfor %}
    for (int at = 0; at < {{ bench.reset_clocks }}; ++at) {
        dut->aclk = 0;
        dut->eval();
        dut->aclk = 1;
        dut->eval();
    }
    dut->aresetn = 1;

    while (running) {
        // Drive while the clock is low; a beat once offered stays until it is accepted. While nothing
        // is offered the payload is wrong on purpose.
        const unsigned stall = stalls[clock & 4095];
        const bool have_input = accepted < inputs;
        const bool have_expected = received < expecteds;
        if (have_input && !offering) offering = stall & 1;
        const Word* payload = have_input ? &input[accepted * input_words] : inverted;
        if (!offering && have_input) {
{%- for signal in bench.input.signals %}
            for (size_t i = 0; i < words({{ signal.width }}); ++i) inverted[{{ signal.word }} + i] = ~payload[{{ signal.word }} + i];
{%- if signal.width % 32 != 0 %}
            inverted[{{ signal.word }} + words({{ signal.width }}) - 1] &= (1u << {{ signal.width % 32 }}) - 1;
{%- endif %}
{%- endfor %}
            payload = inverted;
        }
{%- for signal in bench.input.signals %}
        put(dut->s_axis_{{ signal.name }}, payload + {{ signal.word }});
{%- endfor %}
        dut->s_axis_tvalid = offering;
        dut->m_axis_tready = stall >> 1 & 1;
        dut->aclk = 0;
        dut->eval();
#if VM_TRACE
        if (vcd && clock == vcd_from) wave.open("window.vcd");
        if (wave.isOpen()) wave.dump(10 * (clock + {{ bench.reset_clocks }}));
#endif

        // Look when all is settled, just before the edge.
        ++quiet;
        const bool valid = dut->m_axis_tvalid;
        const bool ready = dut->m_axis_tready;
        if (valid) {
{%- for signal in bench.output.signals %}
            get(dut->m_axis_{{ signal.name }}, got + {{ signal.word }});
{%- endfor %}
        }
        if (held && !unstable) {
            const char* changed = valid ? nullptr : "tvalid";
            for (const Signal& signal : output_signals)
                if (!changed && !same(signal, got, previous)) changed = signal.name;
            if (changed) {
                std::printf("unstable: signal=m_axis_%s clock=%llu beat=%ld\n", changed, Number(clock), received);
                ++failures;
                unstable = true;
            }
        }
        held = valid && !ready;
        if (held) std::memcpy(previous, got, sizeof got);
        if (!first_seen) {
            if (!ready || (have_input && !offering)) stalled = true;
            if (valid) {
                first_seen = true;
                first_clock = clock;
            }
        }
        if (valid && !have_expected) {
            std::printf("extra: clock=%llu beat=%ld\n", Number(clock), received);
            ++failures;
            running = false;
        } else if (valid && ready) {
            write_beat(received_text, clock, got);
            if (!same_beat(&expected[received * output_words], got)) {
                if (mismatches == 0) {
                    std::printf("mismatch: beat=%ld clock=%llu\n", received, Number(clock));
                    ++failures;
                }
                ++mismatches;
            }
            ++received;
            clocks = clock + 1;
            quiet = 0;
        }
        if (offering && dut->s_axis_tready) {
            if (accepted == {{ bench.latency_beat }}) {
                started = true;
                start_clock = clock;
            }
            ++accepted;
            offering = false;
            quiet = 0;
        }
        if (accepted == inputs && received == expecteds) {
            if (++drained > {{ bench.drain_clocks }}) running = false;
        } else if (quiet >= patience) {
            std::printf("hang: clock=%llu beat=%ld accepted=%ld quiet=%llu\n", Number(clock), received, accepted, Number(quiet));
            ++failures;
            running = false;
        }
#if VM_TRACE
        if (vcd && clock == vcd_to) running = false;
#endif

        dut->aclk = 1;
        dut->eval();
#if VM_TRACE
        if (wave.isOpen()) wave.dump(10 * (clock + {{ bench.reset_clocks }}) + 5);
#endif
        ++clock;
    }

    dut->final();
#if VM_TRACE
    wave.close();
#endif
#if VM_COVERAGE
    context->coveragep()->write("coverage.dat");
#endif
    FILE* file = std::fopen("received.hex", "wb");
    if (!file || std::fwrite(received_text.data(), 1, received_text.size(), file) != received_text.size() || std::fclose(file)) {
        std::puts("broken: received.hex cannot be written");
        ++failures;
    }

    const long long latency = static_cast<long long>(first_clock) - static_cast<long long>(start_clock);
{%- if let Some(clocks) = bench.latency_clocks %}
    if (first_seen && started && !stalled && latency != {{ clocks }}) {
        std::printf("latency: expected={{ clocks }} measured=%lld clock=%llu\n", latency, Number(first_clock));
        ++failures;
    }
{%- endif %}
    if (failures == 0 && check_clocks && clocks != expected_clocks) {
        std::printf("clocks: expected=%llu measured=%llu\n", Number(expected_clocks), Number(clocks));
        ++failures;
    }
    std::printf("total: beats=%ld clocks=%llu mismatches=%llu accepted=%ld\n", received, Number(clocks), Number(mismatches), accepted);
    if (first_seen && started) std::printf("measured: latency=%lld stalled=%d\n", latency, stalled);
    std::puts(failures == 0 ? "PASS" : "FAIL");
    return 0;
}
