#include "platform.h"

#include <string.h>

enum { OPEN = 0x01, CLOSE = 0x02, WRITE = 0x05, READ = 0x06, EXIT = 0x18 };
enum { FOR_READING = 1, FOR_WRITING = 5 };          /* "rb" and "wb" */
enum { FINISHED = 0x20026, FAILED = 0x20023 };
enum { PAINTED = 64 * 1024, FREE = 64, MARK = 0xA5 };

#define TIMER ((volatile uint32_t *)0x40000000)     /* control, value, reload */
#define COPROCESSORS (*(volatile uint32_t *)0xE000ED88)

extern uint32_t data_begin[], data_end[], data_load[], bss_begin[], bss_end[], stack_top[];
int main(void);
void reset(void);
static void fault(void);
static int inputs, answers;
static unsigned char *low, *high;

__attribute__((section(".vectors"), used)) static void *const vectors[16] = {
    stack_top, reset, fault, fault, fault, fault, fault, fault, fault, fault, fault, fault, fault, fault, fault, fault
};

static int ask(int operation, const void *words)
{
    register int r0 __asm__("r0") = operation;
    register const void *r1 __asm__("r1") = words;
    __asm__ volatile("bkpt 0xAB" : "+r"(r0) : "r"(r1) : "memory");
    return r0;
}

static void leave(int reason)
{
    ask(EXIT, (const void *)reason);
    for (;;) {}
}

static void fault(void) { leave(FAILED); }

void reset(void)
{
    COPROCESSORS |= 0xFu << 20;                     /* the floating-point unit is off at the start */
    __asm__ volatile("dsb\n isb" ::: "memory");
    memcpy(data_begin, data_load, (size_t)((char *)data_end - (char *)data_begin));
    memset(bss_begin, 0, (size_t)((char *)bss_end - (char *)bss_begin));
    main();
    leave(FAILED);
}

static int opened(const char *name, uint32_t mode)
{
    const uint32_t words[3] = {(uint32_t)name, mode, (uint32_t)strlen(name)};
    const int file = ask(OPEN, words);
    if (file == -1) leave(FAILED);
    return file;
}

void platform_start(void)
{
    inputs = opened("inputs", FOR_READING);
    answers = opened("answers", FOR_WRITING);
    TIMER[2] = 0xFFFFFFFFu;
    TIMER[1] = 0xFFFFFFFFu;
    TIMER[0] = 1u;
}

void platform_read(void *to, size_t bytes)
{
    const uint32_t words[3] = {(uint32_t)inputs, (uint32_t)to, bytes};
    if (ask(READ, words) != 0) leave(FAILED);
}

void platform_write(const void *from, size_t bytes)
{
    const uint32_t words[3] = {(uint32_t)answers, (uint32_t)from, bytes};
    if (bytes != 0 && ask(WRITE, words) != 0) leave(FAILED);
}

uint32_t platform_ticks(void) { return 0xFFFFFFFFu - TIMER[1]; }

__attribute__((noinline)) void platform_paint(void)
{
    unsigned char *at;
    __asm__ volatile("mov %0, sp" : "=r"(high));
    low = high - PAINTED;
    for (at = low; at < high - FREE; at++) *(volatile unsigned char *)at = MARK;
}

__attribute__((noinline)) uint64_t platform_depth(void)
{
    const volatile unsigned char *at = low;
    while (at < high - FREE && *at == MARK) at++;
    return at < high - FREE ? (uint64_t)(high - at) : (uint64_t)FREE;
}

void platform_end(void)
{
    const uint32_t words[1] = {(uint32_t)answers};
    ask(CLOSE, words);
    leave(FINISHED);
}
