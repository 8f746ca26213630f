/* A board that is not there, for the real command: loaded before the C library (LD_PRELOAD), it answers for
 * /dev/gpiochip0 and /dev/spidev0.0 as the kernel would, and stands for two multiplexers, an array and a converter.
 *
 *   BOARD="ROWS COLUMNS ROW_US COLUMN_US BITS_UP_TO_ITS_LAST" BOARD_ROW_PINS="5 6 13 19" BOARD_COLUMN_PINS="17 27 22 23"
 *   BOARD_COUNTS=counts.txt (row by row) BOARD_LOG=log.txt
 *
 * A reading before the lines have settled is the one before it: who does not wait reads wrong counts. */
#define _GNU_SOURCE
#include <dlfcn.h>
#include <errno.h>
#include <fcntl.h>
#include <linux/gpio.h>
#include <linux/spi/spidev.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/ioctl.h>
#include <time.h>
#include <unistd.h>

enum { PINS = 64, FILES = 1024, LINES = 65536 };
enum kind { NONE, CHIP, HANDLE, SPI };

static enum kind kinds[FILES];
static unsigned offsets[FILES][GPIOHANDLES_MAX], handle_lines[FILES];
static int levels[PINS];
static unsigned row_pins[16], column_pins[16], row_bits, column_bits;
static unsigned rows, columns, bits;
static double row_us, column_us, row_at, column_at;
static unsigned counts[LINES], before;
static unsigned long conversions, early, calls;

static double now_us(void) {
    struct timespec at;
    clock_gettime(CLOCK_MONOTONIC, &at);
    return at.tv_sec * 1e6 + at.tv_nsec / 1e3;
}

static unsigned read_pins(const char *name, unsigned *pins) {
    const char *text = getenv(name);
    unsigned count = 0;
    char *end;
    for (; text && count < 16; text = end) {
        unsigned long pin = strtoul(text, &end, 10);
        if (end == text)
            break;
        pins[count++] = pin % PINS;
    }
    return count;
}

static void fail(const char *what) {
    fprintf(stderr, "simulated board: %s\n", what);
    _exit(70);
}

__attribute__((constructor)) static void begin(void) {
    const char *board = getenv("BOARD"), *file = getenv("BOARD_COUNTS");
    if (!board || !file)
        return;
    if (sscanf(board, "%u %u %lf %lf %u", &rows, &columns, &row_us, &column_us, &bits) != 5 || rows * columns > LINES)
        fail("BOARD is ROWS COLUMNS ROW_US COLUMN_US BITS_UP_TO_ITS_LAST");
    row_bits = read_pins("BOARD_ROW_PINS", row_pins);
    column_bits = read_pins("BOARD_COLUMN_PINS", column_pins);
    FILE *in = fopen(file, "r");
    for (unsigned at = 0; in && at < rows * columns; at++)
        if (fscanf(in, "%u%*[, \n]", &counts[at]) != 1)
            fail("BOARD_COUNTS has too few counts");
    if (!in)
        fail("BOARD_COUNTS cannot be read");
    fclose(in);
}

__attribute__((destructor)) static void end(void) {
    const char *name = getenv("BOARD_LOG");
    FILE *out = name && conversions ? fopen(name, "w") : NULL;
    if (!out)
        return;
    fprintf(out, "conversions %lu early %lu pin_calls %lu\n", conversions, early, calls);
    fclose(out);
}

static int pretend(const char *path) {
    enum kind kind = !strcmp(path, "/dev/gpiochip0") ? CHIP : !strcmp(path, "/dev/spidev0.0") ? SPI : NONE;
    if (kind == NONE || !rows)
        return -1;
    int (*real)(const char *, int, ...) = dlsym(RTLD_NEXT, "open");
    int file = real("/dev/null", O_RDWR | O_CLOEXEC);
    if (file >= 0 && file < FILES)
        kinds[file] = kind;
    return file;
}

#define OPEN(NAME)                                                                                                     \
    int NAME(const char *path, int flags, ...) {                                                                       \
        va_list more;                                                                                                  \
        va_start(more, flags);                                                                                         \
        int mode = va_arg(more, int);                                                                                  \
        va_end(more);                                                                                                  \
        int file = pretend(path);                                                                                      \
        int (*real)(const char *, int, ...) = dlsym(RTLD_NEXT, #NAME);                                                 \
        return file >= 0 ? file : real(path, flags, mode);                                                             \
    }
OPEN(open)
OPEN(open64)

int close(int file) {
    int (*real)(int) = dlsym(RTLD_NEXT, "close");
    if (file >= 0 && file < FILES)
        kinds[file] = NONE;
    return real(file);
}

static unsigned address(const unsigned *pins, unsigned count) {
    unsigned input = 0;
    for (unsigned bit = 0; bit < count; bit++)
        input |= (unsigned)levels[pins[bit]] << bit;
    return input;
}

static void set(int handle, const unsigned char *values) {
    unsigned row = address(row_pins, row_bits), column = address(column_pins, column_bits);
    calls++;
    for (unsigned line = 0; line < handle_lines[handle]; line++)
        levels[offsets[handle][line]] = values[line] != 0;
    if (address(row_pins, row_bits) != row)
        row_at = now_us();
    if (address(column_pins, column_bits) != column)
        column_at = now_us();
}

static void convert(unsigned char *bytes, unsigned length) {
    unsigned row = address(row_pins, row_bits), column = address(column_pins, column_bits);
    double now = now_us();
    unsigned count = before;
    if (row >= rows || column >= columns)
        fail("a line that is not there was read");
    if (now - row_at >= row_us && now - column_at >= column_us)
        count = counts[row * columns + column];
    else
        early++;
    before = count;
    conversions++;
    count <<= 16 - bits;
    if (length > 0)
        bytes[0] = count >> 8;
    if (length > 1)
        bytes[1] = count;
}

static int chip(unsigned long request, void *data) {
    if (request == GPIO_GET_CHIPINFO_IOCTL) {
        struct gpiochip_info *info = data;
        memset(info, 0, sizeof *info);
        strcpy(info->name, "gpiochip0");
        info->lines = PINS;
    } else if (request == GPIO_GET_LINEINFO_IOCTL) {
        ((struct gpioline_info *)data)->flags = GPIOLINE_FLAG_IS_OUT;
    } else if (request == GPIO_GET_LINEHANDLE_IOCTL) {
        struct gpiohandle_request *wanted = data;
        int (*real)(const char *, int, ...) = dlsym(RTLD_NEXT, "open");
        int file = real("/dev/null", O_RDWR | O_CLOEXEC);
        if (file < 0 || file >= FILES)
            return errno = EMFILE, -1;
        kinds[file] = HANDLE;
        handle_lines[file] = wanted->lines;
        memcpy(offsets[file], wanted->lineoffsets, sizeof offsets[file]);
        for (unsigned line = 0; line < wanted->lines; line++)
            if (offsets[file][line] >= PINS)
                return errno = EINVAL, -1;
        set(file, wanted->default_values);
        wanted->fd = file;
    } else {
        return errno = ENOTTY, -1;
    }
    return 0;
}

int ioctl(int file, unsigned long request, ...) {
    va_list more;
    va_start(more, request);
    void *data = va_arg(more, void *);
    va_end(more);
    switch (file >= 0 && file < FILES ? kinds[file] : NONE) {
    case CHIP:
        return chip(request, data);
    case HANDLE:
        if (request != GPIOHANDLE_SET_LINE_VALUES_IOCTL)
            return errno = ENOTTY, -1;
        set(file, ((struct gpiohandle_data *)data)->values);
        return 0;
    case SPI:
        if (_IOC_NR(request) == 0) {
            struct spi_ioc_transfer *transfer = data;
            convert((unsigned char *)(unsigned long)transfer->rx_buf, transfer->len);
            return transfer->len;
        }
        if (_IOC_DIR(request) & _IOC_READ)
            memset(data, 0, _IOC_SIZE(request));
        return 0;
    default: {
        int (*real)(int, unsigned long, ...) = dlsym(RTLD_NEXT, "ioctl");
        return real(file, request, data);
    }
    }
}
