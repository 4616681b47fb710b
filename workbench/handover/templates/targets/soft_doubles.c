/* Sums of doubles for Cortex-M3 and M4, by control-workbench: they round what libgcc's __aeabi_dadd does not,
 * where exponents differ by 33.
 * Link with -Wl,--wrap=__aeabi_dadd -Wl,--wrap=__aeabi_dsub -Wl,--wrap=__aeabi_drsub. */
#include <stdint.h>
#include <string.h>

#define IN_CORE_REGISTERS __attribute__((pcs("aapcs"))) /* also where other doubles go in those of floats */
IN_CORE_REGISTERS double __real___aeabi_dadd(double a, double b);
IN_CORE_REGISTERS double __wrap___aeabi_dadd(double a, double b);
IN_CORE_REGISTERS double __wrap___aeabi_dsub(double a, double b);
IN_CORE_REGISTERS double __wrap___aeabi_drsub(double a, double b);

static uint64_t bits_of(double x)
{
    uint64_t word;
    memcpy(&word, &x, sizeof word);
    return word;
}

static uint32_t exponent_of(uint64_t word)
{
    const uint32_t field = (uint32_t)(word >> 52) & 0x7FFu;
    return (field == 0u) ? 1u : field;
}

static uint64_t fraction_of(uint64_t word)
{
    const uint64_t fraction = word & UINT64_C(0xFFFFFFFFFFFFF);
    return (((word >> 52) & 0x7FFu) == 0u) ? fraction : (fraction | UINT64_C(0x10000000000000));
}

/* big - small for a difference of exponents of 33: ten bits more, and a mark for what is below them. */
static uint64_t difference_of(uint64_t big, uint64_t small)
{
    const uint64_t tail = fraction_of(small);
    const uint64_t mark = ((tail & 0x7FFFFFu) != 0u) ? 1u : 0u;
    const uint64_t total = (fraction_of(big) << 10) - (tail >> 23) - mark;
    const uint32_t below = (total < (UINT64_C(1) << 62)) ? 1u : 0u; /* a power of two */
    const uint32_t shift = 10u - below;
    const uint64_t half = UINT64_C(1) << (shift - 1u);
    const uint64_t rest = total & ((half << 1) - 1u);
    uint64_t whole = total >> shift;
    if ((rest > half) || ((rest == half) && ((mark != 0u) || ((whole & 1u) != 0u)))) {
        whole += 1u;
    }
    /* the first bit of `whole` counts up the exponent */
    return (big & (UINT64_C(1) << 63)) | (((uint64_t)(exponent_of(big) - below - 1u) << 52) + whole);
}

/* Kept apart, so that a usual sum saves no registers for it. */
IN_CORE_REGISTERS __attribute__((noinline)) static double rare_sum(double a, double b)
{
    const uint64_t x = bits_of(a);
    const uint64_t y = bits_of(b);
    const uint32_t p = exponent_of(x);
    const uint32_t q = exponent_of(y);
    uint64_t word;
    double sum;
    if ((p == (q + 33u)) && (p != 0x7FFu)) {
        word = difference_of(x, y);
    } else if ((q == (p + 33u)) && (q != 0x7FFu)) {
        word = difference_of(y, x);
    } else {
        return __real___aeabi_dadd(a, b);
    }
    memcpy(&sum, &word, sizeof sum);
    return sum;
}

IN_CORE_REGISTERS double __wrap___aeabi_dadd(double a, double b)
{
    const uint32_t x = (uint32_t)(bits_of(a) >> 32);
    const uint32_t y = (uint32_t)(bits_of(b) >> 32);
    const int32_t apart = (int32_t)((x >> 20) & 0x7FFu) - (int32_t)((y >> 20) & 0x7FFu);
    /* 34 is 33 where the smaller number is subnormal */
    if (((x ^ y) >= 0x80000000u) && ((apart == 33) || (apart == -33) || (apart == 34) || (apart == -34))) {
        return rare_sum(a, b);
    }
    return __real___aeabi_dadd(a, b);
}

IN_CORE_REGISTERS double __wrap___aeabi_dsub(double a, double b)
{
    return __wrap___aeabi_dadd(a, -b);
}

IN_CORE_REGISTERS double __wrap___aeabi_drsub(double a, double b)
{
    return __wrap___aeabi_dadd(b, -a);
}
