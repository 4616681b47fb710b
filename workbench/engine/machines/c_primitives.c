/*
 * Primitives that ask no library: what other languages have as an operation.
 *
 * NAME, MARK and the words in capitals stand for the prefix of a law, the ending of a format, and its types and numbers.
 */

static WORD NAME_bits_MARK(REAL x)
{
    union { REAL number; WORD word; } both;
    both.number = x;
    return both.word;
}

static REAL NAME_number_MARK(WORD w)
{
    union { REAL number; WORD word; } both;
    both.word = w;
    return both.number;
}

static bool NAME_finite_MARK(REAL x)
{
    return (NAME_bits_MARK(x) & INFINITE) != INFINITE; /* also under options that assume it */
}

static bool NAME_defined_MARK(REAL x)
{
    return (NAME_bits_MARK(x) & ~SIGN) <= INFINITE; /* it is a number, or infinite */
}

static REAL NAME_fabs_MARK(REAL x)
{
    return NAME_number_MARK(NAME_bits_MARK(x) & ~SIGN);
}

static REAL NAME_copysign_MARK(REAL x, REAL y)
{
    return NAME_number_MARK((NAME_bits_MARK(x) & ~SIGN) | (NAME_bits_MARK(y) & SIGN));
}

static REAL NAME_trunc_MARK(REAL x)
{
    return (NAME_fabs_MARK(x) < WHOLE) ? NAME_copysign_MARK((REAL)(INTEGER)x, x) : x;
}

static REAL NAME_floor_MARK(REAL x)
{
    const REAL whole = NAME_trunc_MARK(x);
    return (whole > x) ? (whole - ONE) : whole;
}

/* The correctly rounded square root, digit by digit as on paper. */
static REAL NAME_sqrt_MARK(REAL x)
{
    const REAL scaled = (x < SMALLEST) ? (x * UP) : x;
    const WORD pattern = NAME_bits_MARK(scaled);
    const int exponent = (int)(pattern >> DIGITS) - BIAS;
    const unsigned odd = (unsigned)exponent & 1u;
    const int half = (exponent - (int)odd) / 2;
    WORD rest = ((pattern & MANTISSA) | HIDDEN) << odd;
    WORD root = 0u;
    WORD sum = 0u;
    WORD digit = HIDDEN << 1u;
    REAL result = x;
    if ((x > ZERO) && NAME_finite_MARK(x)) {
        int i;
        rest <<= 1u;
        for (i = 0; i < STEPS; ++i) {
            const WORD trial = sum + digit;
            if (trial <= rest) {
                sum = trial + digit;
                rest -= trial;
                root += digit;
            }
            rest <<= 1u;
            digit >>= 1u;
        }
        root += (rest != 0u) ? (root & 1u) : 0u;
        root = (root >> 1u) + ((WORD)half << DIGITS) + OFFSET;
        result = NAME_number_MARK(root);
        result = (x < SMALLEST) ? (result * DOWN) : result;
    } else if ((x < ZERO) || (x != x)) {
        result = NAME_number_MARK(NOT_A_NUMBER);
    } else {
        /* zero and infinity are their own roots */
    }
    return result;
}
