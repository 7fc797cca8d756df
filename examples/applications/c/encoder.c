/* An absolute encoder without a network stack, to be tested by encspec over standard input and output.

   On PROFINET it is an encoder of the encoder profile with telegram 81, on PROFIBUS one of class 2. It needs C99 and nothing else:
   cc -O2 -o encoder encoder.c -lm. The protocol is described in docs/application-protocol.md; `--mistake NAME` makes it deviate on
   purpose. */

#include "json_line.h"

#include <math.h>
#include <stdint.h>
#include <stdio.h>

enum { STEPS = 8192, REVOLUTIONS = 4096, TOTAL = STEPS * REVOLUTIONS };
#define SECOND 1000000000.0
#define FOREVER (1ull << 53)

enum { MAP = 1, TELEGRAM = 2, START_RECORD = 0xBF00, START_LENGTH = 31, PARAMETERS = 0xB02E };
enum { CODE_SEQUENCE = 1, CLASS_4 = 2, PRESET_NOT_XIST1 = 4, SCALING = 8, ALARMS = 16, NOT_COMPATIBLE = 32 };
enum { SENSOR_ERROR = 0x0001, PARKING_ERROR = 0x0003, LIFE_SIGN_ERROR = 0x0F02, MOST_ERRORS = 3 };
enum { LONGEST_RESPONSE = 240, MOST_CONNECTIONS = 8, MOST_CHANGES = 16 };

static const struct { const char *name; int error_type; } FAULTS[] = {
    {"fault.sensor", 0x0009}, {"fault.passing", 0x0005}, {"fault.standing", 0x0006}};
enum { SENSOR, FAULT_COUNT = 3 };

static const char *const DESCRIPTION =
    "\"description\":{\"version\":1,\"name\":\"example encoder in C\","
    "\"stand\":[\"shaft.speed\",\"shaft.counts\",\"turn\",\"fault.sensor\",\"fault.passing\",\"fault.standing\"],"
    "\"profinet\":{\"vendor_id\":65261,\"device_id\":224,\"station_type\":\"EXAMPLE ENCODER\",\"order_id\":\"EXAMPLE-81\","
    "\"serial_number\":\"0001\",\"profile_id\":15616,\"im_supported\":14,\"ports\":2,\"submodules\":["
    "{\"slot\":0,\"module_ident\":1,\"subslot\":1,\"submodule_ident\":1},"
    "{\"slot\":1,\"module_ident\":81,\"subslot\":1,\"submodule_ident\":2,\"api\":15616},"
    "{\"slot\":1,\"module_ident\":81,\"subslot\":2,\"submodule_ident\":81,\"api\":15616,\"inputs\":12,\"outputs\":4}]},"
    "\"profibus\":{\"ident\":65261,\"configuration\":\"D1E1\",\"dpv1\":true,\"fail_safe\":true,\"freeze\":true,\"sync\":true,"
    "\"set_address\":true}}";

static const char *mistake = "";

static int deviates(const char *name) { return strcmp(mistake, name) == 0; }

/* The shaft, in hardware steps without a limit: it turns steadily, or until it has reached a target. */
static struct { uint64_t begin, end; int64_t start, target; double rate; } shaft;

static struct { int appears, fault; } changes[MOST_CHANGES];
static int change_count, diagnosis_changed, faults[FAULT_COUNT];

static struct { uint32_t connection; int length; unsigned char data[LONGEST_RESPONSE]; } responses[MOST_CONNECTIONS];

/* What the supply keeps, the settings, and the state of the connection. */
static int64_t offset, saved_offset, range;
static uint32_t preset_value, saved_preset, units;
static int flags, tolerated, speed_unit, on_profinet;
static uint32_t stw2, g1_stw, g1_zsw;
static int sign, last_sign, account, watches, acknowledging, is_parked, error_count, errors[MOST_ERRORS];

static int64_t shaft_at(uint64_t now) {
    if (now >= shaft.end) return shaft.target;
    return shaft.start + (int64_t)floor(shaft.rate * (double)(now - shaft.begin) / SECOND);
}

static void shaft_speed(uint64_t now, double rpm) {
    shaft.start = shaft_at(now), shaft.begin = now;
    shaft.rate = rpm * STEPS / 60, shaft.end = FOREVER;
}

/* Turns by a distance, and returns when it is done. */
static uint64_t shaft_turn(uint64_t now, double steps, double rpm) {
    shaft_speed(now, copysign(rpm, steps));
    shaft.target = shaft.start + llround(steps);
    shaft.end = now + (uint64_t)ceil(fabs(steps / shaft.rate) * SECOND);
    return shaft.end;
}

static void shaft_place(int64_t counts) {
    shaft.begin = 0, shaft.start = shaft.target = counts;
    shaft.rate = 0, shaft.end = FOREVER;
}

static int64_t modulo(int64_t value, int64_t by) {
    int64_t rest = value % by;
    return rest < 0 ? rest + by : rest;
}

static int is_scaled(void) { return (flags & CLASS_4) && (flags & SCALING); }
static int64_t span(void) { return is_scaled() ? range : TOTAL; }

static int64_t measured(uint64_t now) {
    int64_t counts = shaft_at(now);
    if ((flags & CODE_SEQUENCE) && (flags & CLASS_4) && !deviates("direction")) counts = -counts;
    if (!is_scaled()) return modulo(counts, TOTAL);
    counts *= units;
    return modulo((counts - modulo(counts, STEPS)) / STEPS, range);
}

static int64_t position(uint64_t now) { return modulo(measured(now) + (flags & CLASS_4 ? offset : 0), span()); }

static void preset(uint64_t now, int64_t value, int is_relative) {
    value += deviates("preset");
    offset = saved_offset = modulo(is_relative ? offset + value : value - measured(now), span());
}

static void begin_connection(void) {
    stw2 = g1_stw = g1_zsw = 0;
    sign = last_sign = account = watches = acknowledging = is_parked = 0;
    error_count = 0;
    if (faults[SENSOR]) errors[error_count++] = SENSOR_ERROR;
}

/* Everything that is lost with the supply. */
static void start_up(void) {
    int index;
    flags = CLASS_4 | SCALING | NOT_COMPATIBLE, units = STEPS, range = TOTAL;
    offset = saved_offset;
    preset_value = saved_preset;
    tolerated = 1, speed_unit = 0;
    for (index = 0; index < MOST_CONNECTIONS; index++) responses[index].length = 0;
    begin_connection();
}

static void report(int fault, int appears) {
    diagnosis_changed = 1;
    if (change_count == MOST_CHANGES) return;
    changes[change_count].appears = appears;
    changes[change_count++].fault = fault;
}

static void raise_error(int code) {
    int index = 0;
    while (index < error_count && errors[index] != code) index++;
    if (index == error_count && index < MOST_ERRORS) errors[error_count++] = code;
}

static void set_fault(int fault, int is_present) {
    if (faults[fault] == is_present || (!is_present && deviates("diagnosis"))) return;
    faults[fault] = is_present;
    if (fault == SENSOR && is_present && !is_parked) raise_error(SENSOR_ERROR);
    if (fault != SENSOR || (flags & ALARMS)) report(fault, is_present);
}

/* The sign of life of the controller: a failure weighs ten times as much as a good one. */
static void watch(int new_sign) {
    int last = last_sign, limit = flags & NOT_COMPATIBLE ? 10 : tolerated * 10;
    last_sign = new_sign;
    if (!watches) {
        watches = new_sign != 0;
        return;
    }
    account = new_sign == last % 15 + 1 ? account - (account > 0) : account < limit - 9 ? account + 10 : limit + 1;
    if (account > limit && !is_parked) raise_error(LIFE_SIGN_ERROR);
}

static void take_outputs(uint64_t now, const unsigned char *data, int length) {
    uint32_t new_stw2 = 0, request = 0, new;
    if (length == 4) {
        new_stw2 = (uint32_t)data[0] << 8 | data[1];
        request = (uint32_t)data[2] << 8 | data[3];
        watch((int)(new_stw2 >> 12));
    }
    if ((flags & NOT_COMPATIBLE) && !(new_stw2 & 0x0400)) /* without control by PLC no request is valid */
        request = 0;
    new = request & ~g1_stw;
    if (!(request & 0x4000)) {
        is_parked = 0;
    } else if ((new & 0x4000) && (shaft.rate == 0 || now >= shaft.end)) {
        is_parked = 1;
        acknowledging = error_count = 0;
        g1_zsw = 0;
    } else if (new & 0x4000) {
        raise_error(PARKING_ERROR);
    }
    if ((new & 0x1000) && !is_parked && (flags & CLASS_4)) {
        preset(now, preset_value, (request & 0x0800) != 0);
        g1_zsw |= 0x1000;
    }
    if (!(request & 0x1000)) g1_zsw &= ~0x1000u;
    if ((new & 0x8000) && error_count && !is_parked) {
        acknowledging = 1;
        /* With the mistake it stays while a preset is requested. */
    } else if (!(request & 0x8000) && acknowledging && !(deviates("sequence") && (request & 0x1000))) {
        acknowledging = error_count = 0;
        if (faults[SENSOR]) errors[error_count++] = SENSOR_ERROR;
    }
    stw2 = new_stw2;
    g1_stw = request;
}

static void print_inputs(uint64_t now) {
    uint32_t zsw, status, xist1, xist2 = 0, shown;
    sign = sign % 15 + 1;
    zsw = (uint32_t)sign << 12 | ((flags & NOT_COMPATIBLE) && (stw2 & 0x0400) ? 0x0200 : 0);
    shown = is_parked ? 0 : (uint32_t)position(now);
    status = g1_zsw | (acknowledging ? 0x0800 : 0) | (is_parked ? 0x4000 : 0);
    xist1 = (flags & PRESET_NOT_XIST1) && !is_parked ? (uint32_t)measured(now) : shown;
    if (error_count) {
        status |= 0x8000;
        xist2 = (uint32_t)errors[0];
    } else if ((g1_stw & 0x2000) && !is_parked) {
        status |= 0x2000;
        xist2 = shown;
    }
    printf(",\"inputs\":[{\"slot\":1,\"subslot\":%d,\"data\":\"%04X%04X%08X%08X\",\"good\":%s}]", TELEGRAM, zsw, status, xist1, xist2,
           faults[SENSOR] ? "false" : "true");
}

static uint32_t number_at(const unsigned char *data, int length) {
    uint32_t value = 0;
    while (length-- > 0)
        value = value << 8 | *data++;
    return value;
}

static unsigned char *put(unsigned char *out, uint32_t value, int length) {
    int index;
    for (index = length; index-- > 0; value >>= 8) out[index] = (unsigned char)value;
    return out + length;
}

static int apply(int new_flags, uint32_t new_units, uint32_t new_range) {
    int is_valid = new_units >= 1 && new_units <= STEPS && new_range >= 2 && new_range <= (uint64_t)new_units * REVOLUTIONS;
    if ((new_flags & CLASS_4) && (new_flags & SCALING) && !is_valid) return 0;
    flags = new_flags;
    units = new_units;
    range = new_range;
    return 1;
}

/* A parameter: its format, whether it has subindices and can be written, and its values. */
struct parameter { uint32_t number; int format, is_array, is_writable, count; uint32_t values[12]; };
enum { WORD = 0x42, DOUBLE_WORD = 0x43, OCTETS = 0x0A };

static int find_parameter(uint32_t number, struct parameter *found) {
    const struct parameter table[] = {
        {922, WORD, 0, 0, 1, {81}},
        {925, WORD, 0, 1, 1, {(uint32_t)tolerated}},
        {964, WORD, 1, 0, 6, {0xFEED, 1, 100, 2026, 2811, 1}},
        {965, OCTETS, 0, 0, 2, {0x3D, flags & NOT_COMPATIBLE ? 41 : 31}},
        {971, WORD, 0, 1, 1, {0}},
        {974, WORD, 1, 0, 3, {240, 39, 0}},
        {975, WORD, 1, 0, 8, {0xFEED, 1, 100, 2026, 2811, 0x0005, 0x8000, 1}},
        {979, DOUBLE_WORD, 1, 0, 6, {0x5011, 0x80000000u, STEPS, 0, 0, REVOLUTIONS}},
        {980, WORD, 1, 0, 11, {922, 925, 964, 965, 971, 974, 975, 979, 65000, 65001, 0}},
        {65000, DOUBLE_WORD, 0, 1, 1, {preset_value}},
        {65001, DOUBLE_WORD, 1, 0, 12, {0x000C0101, (uint32_t)flags, faults[SENSOR] ? 1 : 0, 0x0031, 0, 0, 0x01010000, 0xFFFFFFFFu,
                                 (uint32_t)offset, units, (uint32_t)range, (uint32_t)speed_unit}},
    };
    size_t index = 0;
    while (index < sizeof table / sizeof *table && table[index].number != number) index++;
    if (index == sizeof table / sizeof *table) return 0;
    *found = table[index];
    return 1;
}

static int write_parameter(uint32_t number, uint32_t value) {
    if (number == 925 ? value < 1 || value > 255 : number == 971 ? value > 1 : value >= span()) return 0x02;
    if (number == 925) {
        tolerated = (int)value;
    } else if (number == 971) {
        saved_offset = offset;
        saved_preset = preset_value;
    } else {
        preset_value = value;
    }
    return -1;
}

/* One parameter of a request: returns an error number, or -1 after its part of the response was written. `value` is null if the
   request has none; it begins with format and number of values. */
static int access_parameter(const unsigned char *request, const unsigned char *address, const unsigned char *value, int size,
                            unsigned char **out, const unsigned char *end, int *where) {
    struct parameter known;
    int kind = request[1], elements = address[1], index, count, width;
    int subindex = (int)number_at(address + 4, 2);
    uint32_t number = number_at(address + 2, 2);
    if (kind != 1 && kind != 2) return 0x21;
    if (request[2] > 1) return 0x19;
    if (!find_parameter(number, &known)) return 0x00;
    if (address[0] != 0x10) return 0x16;
    if (kind == 2 && !known.is_writable) return 0x01;
    if (!known.is_array && (subindex || elements > 1)) return 0x04;
    count = known.format == OCTETS ? known.count : elements > 1 ? elements : 1;
    if (subindex + count > known.count) {
        *where = subindex > known.count ? subindex : known.count;
        return 0x03;
    }
    width = known.format == WORD ? 2 : known.format == DOUBLE_WORD ? 4 : 1;
    if (kind == 2) {
        if (!value || size == 0) return 0x17;
        if (value[1] != 1) return 0x18;
        return size != width ? 0x05 : write_parameter(number, number_at(value + 2, width));
    }
    if (*out + 3 + count * width > end) return 0x15; /* the response would be too long */
    *(*out)++ = (unsigned char)known.format;
    *(*out)++ = (unsigned char)count;
    for (index = 0; index < count; index++) *out = put(*out, known.values[subindex + index], width);
    if (count * width % 2) *(*out)++ = 0;
    return -1;
}

static int value_size(int format) {
    return strchr("\x41\x05\x02\x0A", format) ? 1 : strchr("\x42\x06\x03", format) ? 2 : strchr("\x43\x07\x04", format) ? 4 : 0;
}

static int respond(const unsigned char *data, int length, unsigned char *response) {
    unsigned char *out = response + 4;
    int count = data[3], at = 4 + 6 * count, index, has_error = 0;
    for (index = 0; index < count; index++) {
        const unsigned char *value = NULL;
        const unsigned char *end = response + LONGEST_RESPONSE - 6 * (count - index - 1);
        int size = 0, where = -1, error;
        if (data[1] == 2 && at + 2 <= length) {
            size = data[at] ? value_size(data[at]) : 0;
            value = at + 2 + data[at + 1] * size <= length ? data + at : NULL;
            at += (2 + data[at + 1] * size + 1) / 2 * 2;
        }
        error = access_parameter(data, data + 4 + 6 * index, value, size, &out, end, &where);
        if (error >= 0) {
            has_error = 1;
            *out++ = 0x44;
            *out++ = where < 0 ? 1 : 2;
            out = put(out, (uint32_t)error, 2);
            if (where >= 0) out = put(out, (uint32_t)where, 2);
        } else if (data[1] == 2) {
            *out++ = 0x40;
            *out++ = 0;
        }
    }
    response[0] = data[0];
    response[1] = (unsigned char)((data[1] == 2 ? 2 : 1) | (has_error ? 0x80 : 0));
    response[2] = data[2];
    response[3] = data[3];
    return data[1] == 2 && !has_error ? 4 : (int)(out - response);
}

static int response_of(uint32_t connection, int is_new) {
    int index, free = -1;
    for (index = 0; index < MOST_CONNECTIONS; index++) {
        if (responses[index].length && responses[index].connection == connection) return index;
        if (!responses[index].length) free = index;
    }
    return is_new ? free : -1;
}

static void print_data(const unsigned char *data, int length) {
    printf(",\"data\":\"");
    while (length-- > 0)
        printf("%02X", *data++);
    printf("\"");
}

/* Reads a record, and returns a word of the protocol if it is refused. */
static const char *read_record(int subslot, int record, uint32_t connection) {
    unsigned char data[START_LENGTH] = {0};
    int index = response_of(connection, 0);
    if (subslot == MAP && record == START_RECORD) {
        put(put(put(data, (uint32_t)flags, 1) + 4, units, 4) + 4, (uint32_t)range, 4);
        data[17] = (unsigned char)tolerated;
        data[18] = (unsigned char)speed_unit;
        print_data(data, START_LENGTH);
        return NULL;
    }
    if (subslot != MAP || record != PARAMETERS) {
        if (!deviates("record")) return "invalid_index";
        print_data((const unsigned char *)"", 1);
        return NULL;
    }
    if (index < 0) return "state_conflict";
    print_data(responses[index].data, responses[index].length);
    responses[index].length = 0;
    return NULL;
}

static const char *write_record(int subslot, int record, uint32_t connection, const unsigned char *data, int length) {
    int index;
    if (subslot == MAP && record == START_RECORD) {
        if (length != START_LENGTH) return "write_length_error";
        if ((data[0] & CLASS_4) && (data[0] & SCALING) && (number_at(data + 1, 4) || number_at(data + 9, 4)))
            return "invalid_parameter";
        if (data[17] < 1 || data[18] > 3) return "invalid_parameter";
        if (!apply(data[0], number_at(data + 5, 4), number_at(data + 13, 4))) return "invalid_parameter";
        tolerated = data[17];
        speed_unit = data[18];
        return NULL;
    }
    if (subslot != MAP || record != PARAMETERS) return "invalid_index";
    if (length < 4 || data[3] < 1 || data[3] > 39 || length < 4 + 6 * data[3]) return "write_length_error";
    index = response_of(connection, 1);
    if (index < 0) return "state_conflict";
    responses[index].connection = connection;
    responses[index].length = respond(data, length, responses[index].data);
    return NULL;
}

/* PROFIBUS, class 2: bit 31 of the outputs requests a preset to the value in the others. */
static void take_dp_outputs(uint64_t now, const unsigned char *data, int length) {
    uint32_t word = length == 4 ? number_at(data, 4) : 0;
    if (word >> 31 && !stw2) {
        preset(now, (int64_t)(word & 0x7FFFFFFF) % span(), 0);
        saved_offset = offset;
    }
    stw2 = word >> 31;
}

static void print_diagnosis(void) {
    int has_fault = faults[0] || faults[1] || faults[2];
    printf(",\"data\":\"33%02X%02X01%08X%04X0000010000000001100100", has_fault, flags & 0x0F, STEPS, REVOLUTIONS);
    printf("FFFFFFFF%08X00000000%08X%08X30303030303030303031\",\"ext_diag\":%s", (uint32_t)offset, units, (uint32_t)range,
           has_fault ? "true" : "false");
}

/* Does an action of the stand; returns when it is done, or 0 if it is unknown. */
static uint64_t act(uint64_t now, const char *message) {
    const char *name = json_get(message, "name"), *value = json_get(message, "value");
    double distance = json_number(value);
    int fault;
    if (json_is(name, "shaft.speed")) {
        shaft_speed(now, distance);
    } else if (json_is(name, "shaft.counts")) {
        shaft_place((int64_t)json_whole(value));
    } else if (json_is(name, "turn")) {
        distance *= json_is(json_get(message, "unit"), "revolutions") ? STEPS : 1;
        return shaft_turn(now, distance, json_number(json_get(message, "rpm")));
    } else {
        for (fault = 0; fault < FAULT_COUNT && !json_is(name, FAULTS[fault].name);) fault++;
        if (fault == FAULT_COUNT) return 0;
        set_fault(fault, json_true(value));
    }
    return now;
}

/* Prints the fields of an answer, beside the word of the message. */
static void answer(const char *message, const char *word) {
    unsigned char data[256];
    uint64_t now = json_whole(json_get(message, "now"));
    uint32_t connection = (uint32_t)json_whole(json_get(message, "connection"));
    int subslot = (int)json_whole(json_get(message, "subslot")), record = (int)json_whole(json_get(message, "index"));
    int length = json_bytes(json_get(message, "data"), data, sizeof data), index;
    const char *refused = NULL, *outputs = json_get(message, "outputs");
    if (json_is(word, "cycle")) {
        for (outputs = json_first(outputs); outputs; outputs = json_next(outputs)) {
            length = json_bytes(json_get(outputs, "data"), data, sizeof data);
            take_outputs(json_whole(json_get(outputs, "at")), data, length);
        }
        if (json_true(json_get(message, "inputs"))) print_inputs(now);
    } else if (json_is(word, "data_exchange")) {
        if (outputs) take_dp_outputs(now, data, json_bytes(outputs, data, sizeof data));
        if (json_true(json_get(message, "inputs")))
            printf(",\"data\":\"%08X\",\"constant_until\":%llu", (uint32_t)position(now),
                   shaft.rate == 0 || now >= shaft.end ? FOREVER : 0);
    } else if (json_is(word, "hello")) {
        on_profinet = json_is(json_get(message, "bus"), "profinet");
        printf(",%s", DESCRIPTION);
    } else if (json_is(word, "reset")) {
        shaft_place((int64_t)json_whole(json_get(message, "shaft")));
        saved_offset = saved_preset = 0;
        memset(faults, 0, sizeof faults);
        start_up();
        change_count = diagnosis_changed = 0;
    } else if (json_is(word, "power_up")) {
        start_up();
        for (index = 0; index < FAULT_COUNT; index++)
            if (faults[index]) report(index, 1);
    } else if (json_is(word, "connect") || json_is(word, "exchange_begins")) {
        begin_connection();
    } else if (json_is(word, "disconnect")) {
        if ((index = response_of(connection, 0)) >= 0) responses[index].length = 0;
    } else if (json_is(word, "read_record")) {
        refused = read_record(subslot, record, connection);
    } else if (json_is(word, "write_record")) {
        refused = write_record(subslot, record, connection, data, length);
    } else if (json_is(word, "factory_reset")) {
        const char *scope = json_get(message, "scope");
        if (json_is(scope, "engineering") || json_is(scope, "factory_image") || json_is(scope, "other")) return;
        if (!json_is(scope, "communication")) saved_offset = saved_preset = offset = preset_value = 0;
        printf(",\"done\":%llu", (unsigned long long)now);
    } else if (json_is(word, "set_prm")) {
        int is_valid = length == 14 && apply(data[3], number_at(data + 4, 4), number_at(data + 8, 4));
        printf(",\"accepted\":%s", is_valid ? "true" : "false");
    } else if (json_is(word, "chk_cfg")) {
        int is_valid = (length == 2 && data[0] == 0xD1 && data[1] == 0xE1) || deviates("configuration");
        printf(",\"accepted\":%s,\"input_length\":4,\"output_length\":4", is_valid ? "true" : "false");
    } else if (json_is(word, "diagnosis")) {
        print_diagnosis();
    } else if (json_is(word, "act")) {
        uint64_t done = act(now, message);
        if (done || !now) printf(",\"done\":%llu", (unsigned long long)done);
    }
    if (refused) printf(",\"refused\":\"%s\"", refused);
}

int main(int count, char **arguments) {
    static char line[65536];
    int index;
    if (count == 3 && strcmp(arguments[1], "--mistake") == 0) mistake = arguments[2];
    while (fgets(line, sizeof line, stdin)) {
        const char *word = json_get(line, "message");
        if (!word) return 1;
        printf("{\"answer\":%.*s", (int)(json_end(word) - word), word);
        answer(line, word);
        if (on_profinet && change_count) {
            printf(",\"diagnosis\":[");
            for (index = 0; index < change_count; index++)
                printf("%s{\"appears\":%s,\"slot\":1,\"subslot\":%d,\"error_type\":%d}", index ? "," : "",
                       changes[index].appears ? "true" : "false", MAP, FAULTS[changes[index].fault].error_type);
            printf("]");
        } else if (!on_profinet && diagnosis_changed) {
            printf(",\"diagnosis_changed\":true");
        }
        change_count = diagnosis_changed = 0;
        printf("}\n");
        fflush(stdout);
    }
    return 0;
}
