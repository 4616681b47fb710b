/*
 * Primitives by C's own library, which compilers turn into an instruction where a processor has one.
 *
 * NAME, MARK and REAL stand as in `c_primitives.c`.
 */

static REAL NAME_sqrt_MARK(REAL x)
{
    return sqrt_MARK(x);
}

static REAL NAME_fma_MARK(REAL x, REAL y, REAL z)
{
    return fma_MARK(x, y, z);
}
