/* A small reader for one line of JSON that is known to be valid, for programs without a library for it.
   A value is a pointer to its first character; a null pointer is a value that is absent. MIT or Apache-2.0. */
#ifndef JSON_LINE_H
#define JSON_LINE_H

#include <stdlib.h>
#include <string.h>

/* Skips spaces. */
static const char *json_space(const char *at)
{
    while (*at == ' ' || *at == '\t' || *at == '\r' || *at == '\n')
        at++;
    return at;
}

/* The end of a value: text, a number, a word, or everything between brackets. */
static const char *json_end(const char *at)
{
    int depth = 0;
    do {
        if (*at == '"') {
            for (at++; *at && *at != '"'; at++)
                if (*at == '\\' && at[1])
                    at++;
        } else if (*at == '{' || *at == '[') {
            depth++;
        } else if (*at == '}' || *at == ']') {
            depth--;
        } else if (depth == 0) {
            while (*at && !strchr(",:]} \t\r\n", *at))
                at++;
            return at;
        }
        if (*at)
            at++;
    } while (*at && depth > 0);
    return at;
}

/* The value of a key of an object. */
static const char *json_get(const char *object, const char *key)
{
    size_t length = strlen(key);
    const char *at;
    if (!object || *object != '{')
        return NULL;
    for (at = json_space(object + 1); *at == '"';) {
        const char *end = json_end(at);
        const char *value = json_space(json_space(end) + 1);
        if ((size_t)(end - at) == length + 2 && memcmp(at + 1, key, length) == 0)
            return value;
        at = json_space(json_end(value));
        if (*at != ',')
            return NULL;
        at = json_space(at + 1);
    }
    return NULL;
}

/* The first element of an array, and the one after an element. */
static const char *json_first(const char *array)
{
    const char *at = array && *array == '[' ? json_space(array + 1) : NULL;
    return at && *at != ']' ? at : NULL;
}

static const char *json_next(const char *element)
{
    const char *at = json_space(json_end(element));
    return *at == ',' ? json_space(at + 1) : NULL;
}

/* Whether a value is this text; texts of the protocol have no escapes. */
static int json_is(const char *value, const char *text)
{
    size_t length = strlen(text);
    return value && *value == '"' && strncmp(value + 1, text, length) == 0 && value[length + 1] == '"';
}

static int json_true(const char *value)
{
    return value && *value == 't';
}

static double json_number(const char *value)
{
    return value ? strtod(value, NULL) : 0.0;
}

static unsigned long long json_whole(const char *value)
{
    return value ? strtoull(value, NULL, 10) : 0;
}

/* The bytes of a text of hexadecimal digits; returns how many there are, at most `most`, or -1 for null and absent ones. */
static int json_bytes(const char *value, unsigned char *bytes, int most)
{
    int count = 0;
    if (!value || *value != '"')
        return -1;
    for (value++; count < most && value[0] != '"' && value[1]; value += 2) {
        char digits[3] = {value[0], value[1], 0};
        bytes[count++] = (unsigned char)strtoul(digits, NULL, 16);
    }
    return count;
}

#endif
