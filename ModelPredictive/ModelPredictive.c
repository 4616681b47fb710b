/*
 * ModelPredictive: a control law that runs once in 0.02 s.
 *
 * Made by control-workbench 0.1.0.
 * Fingerprint of its equations and numbers: 4fff60d38b790f2b
 * Numbers of 64 bits (double precision), each product and each sum rounded by itself: the portable
 *     arithmetic.
 * Compile it without options that change arithmetic, such as -ffast-math, -funsafe-math-optimizations,
 *     or -ffp-contract=fast of clang.
 * On Cortex-M3 and M4 GCC's library rounds some differences wrongly: take the form cortex-m4.
 *
 * A call makes at most 4099 sums, 4762 products, 13 quotients, 1790 comparisons and choices, 60
 *     changes of sign, 385 fmax, 64 fmin; 25 of them depend on numbers of the law alone.
 * Stack of a call: 56 bytes, measured: as gcc 12.2.0 -O2 lays it out for x86_64-linux-gnu.
 * Static memory: 1,944 bytes of state, 1,768 of them for the arrays of loops. Tables of its numbers:
 *     320 bytes of constants.
 * Link flags: none, not even -lm. It calls no function of a library.
 *
 * It reads x [m], xd [m/s], phi [rad], phid [rad/s].
 * It follows x [m].
 * It commands F [N].
 * Limits of F: -3 to 3 N.
 * Safe command, where a flag is raised: F = 0 N. The memory then stays, but for commands on their way,
 *     which become the safe one; after a long gap call the reset.
 * All is in the state: one for each loop, whose calls do not overlap. A period without a call is lost.
 * Note: the observer uses the true signals xd and phid, which no instrument gives.
 * Note: xd, phid: an input that no instrument of the plant gives.
 */
#include "ModelPredictive.h"

#include <float.h>
#include <stdbool.h>

#if defined(__FAST_MATH__) || defined(__ASSOCIATIVE_MATH__) || defined(__RECIPROCAL_MATH__) || \
    defined(__NO_SIGNED_ZEROS__) || (defined(__FINITE_MATH_ONLY__) && (__FINITE_MATH_ONLY__ > 0))
#error "This law needs each operation rounded as IEEE 754 says: compile it without -ffast-math and its parts."
#endif
#if FLT_EVAL_METHOD != 0
#error "This law needs operations of the width of their type: on x86 compile it with -msse2 -mfpmath=sse."
#endif
#if defined(__clang__)
#pragma STDC FP_CONTRACT OFF
#elif defined(__GNUC__)
#pragma GCC optimize ("fp-contract=off")
#elif defined(_MSC_VER)
#pragma fp_contract (off)
#endif

static uint64_t ModelPredictive_bits(double x)
{
    union { double number; uint64_t word; } both;
    both.number = x;
    return both.word;
}

static bool ModelPredictive_finite(double x)
{
    return (ModelPredictive_bits(x) & 0x7ff0000000000000u) != 0x7ff0000000000000u; /* also under options that assume it */
}

static bool ModelPredictive_defined(double x)
{
    return (ModelPredictive_bits(x) & ~0x8000000000000000u) <= 0x7ff0000000000000u; /* it is a number, or infinite */
}

static double ModelPredictive_number(uint64_t w)
{
    union { double number; uint64_t word; } both;
    both.word = w;
    return both.number;
}

static double ModelPredictive_fabs(double x)
{
    return ModelPredictive_number(ModelPredictive_bits(x) & ~0x8000000000000000u);
}

/* The larger number; of a number and what is none, the number. */
static double ModelPredictive_fmax(double a, double b)
{
    const bool t0 = b != b;
    const bool t1 = a >= b;
    const double v2 = t1 ? a : b;
    const double v3 = t0 ? a : v2;
    return v3;
}

/* The smaller number; of a number and what is none, the number. */
static double ModelPredictive_fmin(double a, double b)
{
    const bool t0 = b != b;
    const bool t1 = a <= b;
    const double v2 = t1 ? a : b;
    const double v3 = t0 ? a : v2;
    return v3;
}

static bool ModelPredictive_advance(ModelPredictive_state *state,
                                    const ModelPredictive_readings *readings,
                                    const ModelPredictive_references *references,
                                    ModelPredictive_commands *commands)
{
    /* Readings and memory */
    const double x = readings->x;
    const double xd = readings->xd;
    const double phi = readings->phi;
    const double phid = readings->phid;
    const double x_ref = references->x;
    const double worst = state->controller_worst;

    /*
     * Numbers of the law. To change one, edit its line here: all that depends on it is computed from this
     * line, and equal numbers are not merged. The start of the memory, the safe command and the period are
     * not made of them.
     */
    const double A_11 = 1.0; /* controller.A[0,0] */
    const double A_21 = 0.0; /* controller.A[1,0] */
    const double A_31 = 0.0; /* controller.A[2,0] */
    const double A_41 = 0.0; /* controller.A[3,0] */
    const double A_12 = 0.019963672309962543; /* controller.A[0,1] */
    const double A_22 = 0.9963686220252399; /* controller.A[1,1] */
    const double A_32 = -9.089344441037128e-05; /* controller.A[2,1] */
    const double A_42 = -0.009093289188930596; /* controller.A[3,1] */
    const double A_13 = 0.0005344534531329832; /* controller.A[0,2] */
    const double A_23 = 0.05346854043091191; /* controller.A[1,2] */
    const double A_33 = 1.0062412279873636; /* controller.A[2,2] */
    const double A_43 = 0.6246903941158607; /* controller.A[3,2] */
    const double A_14 = 3.5626204872661906e-06; /* controller.A[0,3] */
    const double A_24 = 0.0005344534531329832; /* controller.A[1,3] */
    const double A_34 = 0.020041593593411462; /* controller.A[2,3] */
    const double A_44 = 1.0062412279873636; /* controller.A[3,3] */
    const double B_11 = 0.00036327690037460175; /* controller.B[0,0] */
    const double B_21 = 0.03631377974760129; /* controller.B[1,0] */
    const double B_31 = 0.000908934444103713; /* controller.B[2,0] */
    const double B_41 = 0.09093289188930598; /* controller.B[3,0] */
    const double K_11 = -7.81716005145486; /* controller.K[0,0] */
    const double K_12 = -7.56933144106675; /* controller.K[0,1] */
    const double K_13 = 38.00607789731999; /* controller.K[0,2] */
    const double K_14 = 7.632533046549959; /* controller.K[0,3] */
    const double S_11 = 6.110799127006173; /* controller.S[0,0] */
    const double F_11 = 0.0; /* controller.F[0,0] */
    const double F_12 = 0.0; /* controller.F[0,1] */
    const double F_13 = 0.0; /* controller.F[0,2] */
    const double F_14 = 0.0; /* controller.F[0,3] */
    const double E_11 = 1.0; /* controller.E[0,0] */
    const double low_1 = -3.0; /* controller.low[0] */
    const double high_1 = 3.0; /* controller.high[0] */
    const double softness_1 = 0.0; /* controller.softness[0] */
    const double sigma_1 = 7.739221162088956; /* controller.sigma[0] */
    const double L_1 = -0.7724509664555177; /* controller.L[0] */
    const double L_2 = -0.5426657823024984; /* controller.L[1] */
    const double cap = 0.5; /* controller.cap [1] */
    const double x_0_1 = 0.0; /* controller.x0[0] */
    const double x_0_2 = 0.0; /* controller.x0[1] */
    const double x_0_3 = 0.0; /* controller.x0[2] */
    const double x_0_4 = 0.0; /* controller.x0[3] */
    const double u_0_1 = 0.0; /* controller.u0[0] */
    static const double W_table[40] = {
        -1.4981247444836792, /* controller.W[0,0] */
        0.9325585957052628, /* controller.W[0,1] */
        -1.3279299690209618, /* controller.W[1,0] */
        0.7031093145267518, /* controller.W[1,1] */
        -1.175731379695414, /* controller.W[2,0] */
        0.4786574416566922, /* controller.W[2,1] */
        -1.039634796178919, /* controller.W[3,0] */
        0.2623162144060468, /* controller.W[3,1] */
        -0.917942328596201, /* controller.W[4,0] */
        0.05697535872031492, /* controller.W[4,1] */
        -0.8091316199955073, /* controller.W[5,0] */
        -0.13471588804775214, /* controller.W[5,1] */
        -0.7118372129627574, /* controller.W[6,0] */
        -0.3103645586218963, /* controller.W[6,1] */
        -0.6248338140430157, /* controller.W[7,0] */
        -0.4678482343059876, /* controller.W[7,1] */
        -0.5470212524083495, /* controller.W[8,0] */
        -0.6053275381501276, /* controller.W[8,1] */
        -0.4774109495288235, /* controller.W[9,0] */
        -0.7212565888986119, /* controller.W[9,1] */
        -0.415113734705104, /* controller.W[10,0] */
        -0.8143911935226901, /* controller.W[10,1] */
        -0.3593288574219212, /* controller.W[11,0] */
        -0.8837945906063296, /* controller.W[11,1] */
        -0.30933406177237355, /* controller.W[12,0] */
        -0.9288405936458706, /* controller.W[12,1] */
        -0.2644766008529275, /* controller.W[13,0] */
        -0.9492140219659432, /* controller.W[13,1] */
        -0.22416508018720835, /* controller.W[14,0] */
        -0.9449083469469963, /* controller.W[14,1] */
        -0.18786202903451574, /* controller.W[15,0] */
        -0.9162205220938026, /* controller.W[15,1] */
        -0.15507710699107996, /* controller.W[16,0] */
        -0.8637430066314219, /* controller.W[16,1] */
        -0.12536086069774535, /* controller.W[17,0] */
        -0.7883530332765102, /* controller.W[17,1] */
        -0.09829895181242151, /* controller.W[18,0] */
        -0.691199211082983, /* controller.W[18,1] */
        -0.07350678276130057, /* controller.W[19,0] */
        -0.5736855932982882, /* controller.W[19,1] */
    };
    const double w_1 = F_14 - (K_14 * E_11);
    const double w_2 = F_13 - (K_13 * E_11);
    const double w_3 = F_12 - (K_12 * E_11);
    const double w_4 = F_11 - (K_11 * E_11);
    const double w_5 = A_44 - (K_14 * B_41);
    const double w_6 = A_43 - (K_13 * B_41);
    const double w_7 = A_42 - (K_12 * B_41);
    const double w_8 = A_41 - (K_11 * B_41);
    const double w_9 = A_34 - (K_14 * B_31);
    const double w_10 = A_33 - (K_13 * B_31);
    const double w_11 = A_32 - (K_12 * B_31);
    const double w_12 = A_31 - (K_11 * B_31);
    const double w_13 = A_24 - (K_14 * B_21);
    const double w_14 = A_23 - (K_13 * B_21);
    const double w_15 = A_22 - (K_12 * B_21);
    const double w_16 = A_21 - (K_11 * B_21);
    const double w_17 = A_14 - (B_11 * K_14);
    const double w_18 = A_13 - (B_11 * K_13);
    const double w_19 = A_12 - (B_11 * K_12);
    const double w_20 = A_11 - (B_11 * K_11);

    /*
     * Law: ModelPredictive
     *
     * Linear model predictive control: the first input of a plan of N stages, computed anew in each period.
     *
     * The plan minimises the sum of e'Q e + v'R v over the stages, with e and v the deviations of states and inputs from
     * a rest, and with the cost of the LQR law behind the last stage. It keeps low <= F e + E v <= high at each stage. A
     * fixed number of sweeps solves it: see `planning.linear_mpc.splitting`, whose numbers the block holds.
     * `ModelPredictive.of` makes the law of a design.
     *
     * Where no limit acts, u = u0 - K (x - x0): the law is LQR. The memory `residual` is the residual before the last
     * sweep, as a share of the distance between the limits of a row, and `worst` the largest so far. A run in which it
     * passes `residual_bounds` is beyond the sample of its design, and the run's warnings say so.
     */
    const double w_21 = x_ref - x_0_1;
    const double w_22 = w_21 * F_11;
    const double w_23 = x - x_0_1 - w_21;
    const double w_24 = phid - x_0_4;
    const double w_25 = phi - x_0_3;
    const double w_26 = xd - x_0_2;
    double carried_1[5];
    double *const made_1a = state->loop_room;
    double *const made_1b = state->loop_room + 20;
    carried_1[0] = w_23;
    carried_1[1] = w_26;
    carried_1[2] = w_25;
    carried_1[3] = w_24;
    carried_1[4] = 0.0;
    for (int pass_1 = 0; pass_1 < 20; ++pass_1) {
        const double *const row_1 = state->controller_plan + pass_1;
        const double w_27 = carried_1[0];
        const double w_28 = carried_1[1];
        const double w_29 = carried_1[2];
        const double w_30 = carried_1[3];
        const double w_31 = (w_30 * w_1) + ((w_29 * w_2) + ((w_28 * w_3) + (w_27 * w_4))) + w_22;
        const double w_32 = (w_17 * w_30) + ((w_18 * w_29) + ((w_19 * w_28) + (w_20 * w_27)));
        const double w_33 = (w_30 * w_13) + ((w_29 * w_14) + ((w_28 * w_15) + (w_27 * w_16)));
        const double w_34 = (w_30 * w_9) + ((w_29 * w_10) + ((w_28 * w_11) + (w_27 * w_12)));
        const double w_35 = (w_30 * w_5) + ((w_29 * w_6) + ((w_28 * w_7) + (w_27 * w_8)));
        const double w_36 = ModelPredictive_fmax(carried_1[4], ((w_31 < low_1) || (high_1 < w_31)) ? 1.0 : 0.0);
        const double w_37 = w_31 + row_1[0];
        made_1a[pass_1] = w_31;
        made_1b[pass_1] = w_37;
        carried_1[0] = w_32;
        carried_1[1] = w_33;
        carried_1[2] = w_34;
        carried_1[3] = w_35;
        carried_1[4] = w_36;
    }
    const double w_38 = carried_1[4];
    const double w_39 = 1.0 / sigma_1;
    const double w_40 = 1.0 / (high_1 - low_1);
    const double w_41 = 1.0 / L_1;
    const double w_42 = 1.0 / L_2;
    double *const carried_2 = state->loop_room + 40;
    for (int copy_2 = 0; copy_2 < 20; ++copy_2) {
        carried_2[copy_2] = made_1b[copy_2];
    }
    carried_2[20] = 0.0;
    for (int pass_2 = 0; pass_2 < 3; ++pass_2) {
        double carried_3[5];
        double *const made_3a = state->loop_room + 61;
        double *const made_3b = state->loop_room + 81;
        double *const made_3c = state->loop_room + 101;
        carried_3[0] = 0.0;
        carried_3[1] = 0.0;
        carried_3[2] = 0.0;
        carried_3[3] = 0.0;
        carried_3[4] = 0.0;
        for (int pass_3 = 19; pass_3 >= 0; --pass_3) {
            const double *const row_3 = carried_2 + pass_3;
            const double w_43 = row_3[0];
            const double w_44 = ModelPredictive_fmin(ModelPredictive_fmax(w_43, low_1), high_1);
            const double w_45 = (w_43 != w_44) ? 1.0 : carried_3[4];
            const double w_46 = (w_43 - w_44) * w_39;
            double w_47;
            if (w_45 != 0.0) {
                const double w_48 = carried_3[0];
                const double w_49 = carried_3[1];
                const double w_50 = carried_3[2];
                const double w_51 = carried_3[3];
                const double w_52 = (E_11 * w_46) + ((B_41 * w_51) + ((B_31 * w_50) + ((B_21 * w_49) + (B_11 * w_48))));
                w_47 = S_11 * w_52;
                const double w_53 = (w_4 * w_46) + ((w_8 * w_51) + ((w_12 * w_50) + ((w_16 * w_49) + (w_20 * w_48))));
                const double w_54 = (w_46 * w_3) + ((w_51 * w_7) + ((w_50 * w_11) + ((w_49 * w_15) + (w_48 * w_19))));
                const double w_55 = (w_46 * w_2) + ((w_51 * w_6) + ((w_50 * w_10) + ((w_49 * w_14) + (w_48 * w_18))));
                const double w_56 = (w_46 * w_1) + ((w_51 * w_5) + ((w_50 * w_9) + ((w_49 * w_13) + (w_48 * w_17))));
                carried_3[0] = w_53;
                carried_3[1] = w_54;
                carried_3[2] = w_55;
                carried_3[3] = w_56;
            } else {
                w_47 = 0.0;
            }
            const double w_57 = (w_46 * softness_1) + w_44;
            const double w_58 = (!(w_43 == w_44)) ? w_39 : 0.0;
            made_3a[pass_3] = w_47;
            made_3b[pass_3] = w_57;
            made_3c[pass_3] = w_58;
            carried_3[4] = w_45;
        }
        const double w_59 = carried_3[4];
        double carried_4[5];
        double *const made_4 = state->loop_room + 121;
        carried_4[0] = 0.0;
        carried_4[1] = 0.0;
        carried_4[2] = 0.0;
        carried_4[3] = 0.0;
        carried_4[4] = 0.0;
        for (int pass_4 = 0; pass_4 < 20; ++pass_4) {
            const double *const row_4a = made_3a + pass_4;
            const double *const row_4b = made_3b + pass_4;
            const double *const row_4c = made_1a + pass_4;
            double w_60;
            if (w_59 != 0.0) {
                const double w_61 = carried_4[0];
                const double w_62 = carried_4[1];
                const double w_63 = carried_4[2];
                const double w_64 = carried_4[3];
                const double w_65 = row_4a[0];
                w_60 = (w_65 * E_11) + ((w_64 * w_1) + ((w_63 * w_2) + ((w_62 * w_3) + (w_61 * w_4))));
                const double w_66 = (B_11 * w_65) + ((w_17 * w_64) + ((w_18 * w_63) + ((w_19 * w_62) + (w_20 * w_61))));
                const double w_67 = (w_65 * B_21) + ((w_64 * w_13) + ((w_63 * w_14) + ((w_62 * w_15) + (w_61 * w_16))));
                const double w_68 = (w_65 * B_31) + ((w_64 * w_9) + ((w_63 * w_10) + ((w_62 * w_11) + (w_61 * w_12))));
                const double w_69 = (w_65 * B_41) + ((w_64 * w_5) + ((w_63 * w_6) + ((w_62 * w_7) + (w_61 * w_8))));
                carried_4[0] = w_66;
                carried_4[1] = w_67;
                carried_4[2] = w_68;
                carried_4[3] = w_69;
            } else {
                w_60 = 0.0;
            }
            const double w_70 = row_4c[0] - w_60 - row_4b[0];
            const double w_71 = ModelPredictive_fmax(carried_4[4], ModelPredictive_fabs(w_70) * w_40);
            made_4[pass_4] = w_70;
            carried_4[4] = w_71;
        }
        double carried_5[5];
        carried_5[0] = 0.0;
        carried_5[1] = 0.0;
        carried_5[2] = 0.0;
        carried_5[3] = 0.0;
        carried_5[4] = 0.0;
        for (int pass_5 = 0; pass_5 < 20; ++pass_5) {
            const double *const row_5a = made_4 + pass_5;
            const double *const row_5b = made_3c + pass_5;
            const double *const row_5c = W_table + 2 * pass_5;
            const double w_72 = row_5b[0];
            const bool w_73 = w_72 != 0.0;
            if (w_73) {
                const double w_74 = row_5c[1];
                const double w_75 = w_72 * w_74;
                const double w_76 = carried_5[4];
                const double w_77 = row_5a[0];
                const double w_78 = row_5c[0];
                const double w_79 = w_72 * w_78;
                const double w_80 = carried_5[3];
                const double w_81 = carried_5[2];
                const double w_82 = carried_5[1];
                const double w_83 = carried_5[0];
                carried_5[0] = (w_78 * w_79) + w_83;
                carried_5[1] = (w_78 * w_75) + w_82;
                carried_5[2] = (w_74 * w_75) + w_81;
                carried_5[3] = (w_79 * w_77) + w_80;
                carried_5[4] = (w_75 * w_77) + w_76;
            }
        }
        double w_84;
        double w_85;
        if (w_59 != 0.0) {
            const double w_86 = 1.0 / (carried_5[0] + w_41);
            const double w_87 = carried_5[1];
            const double w_88 = w_87 * w_86;
            const double w_89 = carried_5[3];
            const double w_90 = (carried_5[4] - (w_89 * w_88)) * (1.0 / (carried_5[2] + w_42 - (w_87 * w_88)));
            w_84 = (w_89 * w_86) - (w_88 * w_90);
            w_85 = w_90;
        } else {
            w_84 = 0.0;
            w_85 = 0.0;
        }
        double carried_6[1];
        double *const made_6 = state->loop_room + 141;
        carried_6[0] = 0.0;
        for (int pass_6 = 0; pass_6 < 20; ++pass_6) {
            const double *const row_6a = carried_2 + pass_6;
            const double *const row_6b = made_4 + pass_6;
            const double *const row_6c = W_table + 2 * pass_6;
            const double w_91 = row_6b[0] - ((w_59 != 0.0) ? ((row_6c[1] * w_85) + (row_6c[0] * w_84)) : 0.0);
            const double w_92 = row_6a[0];
            const double w_93 = (w_92 <= high_1) ? ModelPredictive_fmax(w_92 + w_91 - high_1, 0.0) : 0.0;
            const double w_94 = (low_1 <= w_92) ? ModelPredictive_fmax(low_1 - w_92 - w_91, 0.0) : 0.0;
            const double w_95 = ModelPredictive_fmax(carried_6[0], ModelPredictive_fmax(w_93, w_94) * w_40);
            made_6[pass_6] = w_91;
            carried_6[0] = w_95;
        }
        const double w_96 = ModelPredictive_fmin(1.0, cap * (1.0 / ModelPredictive_fmax(carried_6[0], cap)));
        double *const made_7 = state->loop_room + 161;
        for (int pass_7 = 0; pass_7 < 20; ++pass_7) {
            const double *const row_7a = carried_2 + pass_7;
            const double *const row_7b = made_6 + pass_7;
            const double w_97 = (row_7b[0] * w_96) + row_7a[0];
            made_7[pass_7] = w_97;
        }
        const double w_98 = (w_38 != 0.0) ? made_7[0] : carried_2[0];
        const double w_99 = (w_38 != 0.0) ? made_7[1] : carried_2[1];
        const double w_100 = (w_38 != 0.0) ? made_7[2] : carried_2[2];
        const double w_101 = (w_38 != 0.0) ? made_7[3] : carried_2[3];
        const double w_102 = (w_38 != 0.0) ? made_7[4] : carried_2[4];
        const double w_103 = (w_38 != 0.0) ? made_7[5] : carried_2[5];
        const double w_104 = (w_38 != 0.0) ? made_7[6] : carried_2[6];
        const double w_105 = (w_38 != 0.0) ? made_7[7] : carried_2[7];
        const double w_106 = (w_38 != 0.0) ? made_7[8] : carried_2[8];
        const double w_107 = (w_38 != 0.0) ? made_7[9] : carried_2[9];
        const double w_108 = (w_38 != 0.0) ? made_7[10] : carried_2[10];
        const double w_109 = (w_38 != 0.0) ? made_7[11] : carried_2[11];
        const double w_110 = (w_38 != 0.0) ? made_7[12] : carried_2[12];
        const double w_111 = (w_38 != 0.0) ? made_7[13] : carried_2[13];
        const double w_112 = (w_38 != 0.0) ? made_7[14] : carried_2[14];
        const double w_113 = (w_38 != 0.0) ? made_7[15] : carried_2[15];
        const double w_114 = (w_38 != 0.0) ? made_7[16] : carried_2[16];
        const double w_115 = (w_38 != 0.0) ? made_7[17] : carried_2[17];
        const double w_116 = (w_38 != 0.0) ? made_7[18] : carried_2[18];
        const double w_117 = (w_38 != 0.0) ? made_7[19] : carried_2[19];
        const double w_118 = (w_38 != 0.0) ? carried_4[4] : carried_2[20];
        carried_2[0] = w_98;
        carried_2[1] = w_99;
        carried_2[2] = w_100;
        carried_2[3] = w_101;
        carried_2[4] = w_102;
        carried_2[5] = w_103;
        carried_2[6] = w_104;
        carried_2[7] = w_105;
        carried_2[8] = w_106;
        carried_2[9] = w_107;
        carried_2[10] = w_108;
        carried_2[11] = w_109;
        carried_2[12] = w_110;
        carried_2[13] = w_111;
        carried_2[14] = w_112;
        carried_2[15] = w_113;
        carried_2[16] = w_114;
        carried_2[17] = w_115;
        carried_2[18] = w_116;
        carried_2[19] = w_117;
        carried_2[20] = w_118;
    }
    const double w_119 = ModelPredictive_fmin(ModelPredictive_fmax((w_38 != 0.0) ? carried_2[0] : made_1a[0], low_1), high_1);
    const double F = w_119 + u_0_1;

    /* Memory of the controller */
    const double w_120 = carried_2[19];
    double *const array_8 = state->loop_room + 181;
    for (int copy_8 = 0; copy_8 < 19; ++copy_8) {
        array_8[copy_8] = (carried_2 + 1)[copy_8];
    }
    array_8[19] = w_120;
    const double w_121 = (B_11 * w_119) + ((w_24 * A_14) + ((w_25 * A_13) + ((w_26 * A_12) + (w_23 * A_11))));
    const double w_122 = (B_21 * w_119) + ((w_24 * A_24) + ((w_25 * A_23) + ((w_26 * A_22) + (w_23 * A_21))));
    const double w_123 = (B_31 * w_119) + ((w_24 * A_34) + ((w_25 * A_33) + ((w_26 * A_32) + (w_23 * A_31))));
    const double w_124 = (B_41 * w_119) + ((w_24 * A_44) + ((w_25 * A_43) + ((w_26 * A_42) + (w_23 * A_41))));
    double carried_9[4];
    double *const made_9 = state->loop_room + 201;
    carried_9[0] = w_121;
    carried_9[1] = w_122;
    carried_9[2] = w_123;
    carried_9[3] = w_124;
    for (int pass_9 = 0; pass_9 < 20; ++pass_9) {
        const double *const row_9 = array_8 + pass_9;
        double w_125;
        if (w_38 != 0.0) {
            const double w_126 = carried_9[0];
            const double w_127 = carried_9[1];
            const double w_128 = carried_9[2];
            const double w_129 = carried_9[3];
            const double w_130 = row_9[0] - ((w_129 * w_1) + ((w_128 * w_2) + ((w_127 * w_3) + (w_126 * w_4))));
            w_125 = w_130 - w_22;
            const double w_131 = (w_17 * w_129) + ((w_18 * w_128) + ((w_19 * w_127) + (w_20 * w_126)));
            const double w_132 = (w_129 * w_13) + ((w_128 * w_14) + ((w_127 * w_15) + (w_126 * w_16)));
            const double w_133 = (w_129 * w_9) + ((w_128 * w_10) + ((w_127 * w_11) + (w_126 * w_12)));
            const double w_134 = (w_129 * w_5) + ((w_128 * w_6) + ((w_127 * w_7) + (w_126 * w_8)));
            carried_9[0] = w_131;
            carried_9[1] = w_132;
            carried_9[2] = w_133;
            carried_9[3] = w_134;
        } else {
            w_125 = 0.0;
        }
        made_9[pass_9] = w_125;
    }
    const double plan_next_1 = made_9[0];
    const double plan_next_2 = made_9[1];
    const double plan_next_3 = made_9[2];
    const double plan_next_4 = made_9[3];
    const double plan_next_5 = made_9[4];
    const double plan_next_6 = made_9[5];
    const double plan_next_7 = made_9[6];
    const double plan_next_8 = made_9[7];
    const double plan_next_9 = made_9[8];
    const double plan_next_10 = made_9[9];
    const double plan_next_11 = made_9[10];
    const double plan_next_12 = made_9[11];
    const double plan_next_13 = made_9[12];
    const double plan_next_14 = made_9[13];
    const double plan_next_15 = made_9[14];
    const double plan_next_16 = made_9[15];
    const double plan_next_17 = made_9[16];
    const double plan_next_18 = made_9[17];
    const double plan_next_19 = made_9[18];
    const double plan_next_20 = made_9[19];
    const double residual = carried_2[20];
    const double worst_next = ModelPredictive_fmax(worst, residual);

    /* Nothing is kept that is not finite. */
    const bool done = ModelPredictive_finite(plan_next_1) &&
        ModelPredictive_finite(plan_next_2) &&
        ModelPredictive_finite(plan_next_3) &&
        ModelPredictive_finite(plan_next_4) &&
        ModelPredictive_finite(plan_next_5) &&
        ModelPredictive_finite(plan_next_6) &&
        ModelPredictive_finite(plan_next_7) &&
        ModelPredictive_finite(plan_next_8) &&
        ModelPredictive_finite(plan_next_9) &&
        ModelPredictive_finite(plan_next_10) &&
        ModelPredictive_finite(plan_next_11) &&
        ModelPredictive_finite(plan_next_12) &&
        ModelPredictive_finite(plan_next_13) &&
        ModelPredictive_finite(plan_next_14) &&
        ModelPredictive_finite(plan_next_15) &&
        ModelPredictive_finite(plan_next_16) &&
        ModelPredictive_finite(plan_next_17) &&
        ModelPredictive_finite(plan_next_18) &&
        ModelPredictive_finite(plan_next_19) &&
        ModelPredictive_finite(plan_next_20) &&
        ModelPredictive_finite(worst_next) &&
        ModelPredictive_finite(F) &&
        ModelPredictive_defined(worst) &&
        ModelPredictive_defined(residual);
    if (done) {
        state->controller_plan[0] = plan_next_1;
        state->controller_plan[1] = plan_next_2;
        state->controller_plan[2] = plan_next_3;
        state->controller_plan[3] = plan_next_4;
        state->controller_plan[4] = plan_next_5;
        state->controller_plan[5] = plan_next_6;
        state->controller_plan[6] = plan_next_7;
        state->controller_plan[7] = plan_next_8;
        state->controller_plan[8] = plan_next_9;
        state->controller_plan[9] = plan_next_10;
        state->controller_plan[10] = plan_next_11;
        state->controller_plan[11] = plan_next_12;
        state->controller_plan[12] = plan_next_13;
        state->controller_plan[13] = plan_next_14;
        state->controller_plan[14] = plan_next_15;
        state->controller_plan[15] = plan_next_16;
        state->controller_plan[16] = plan_next_17;
        state->controller_plan[17] = plan_next_18;
        state->controller_plan[18] = plan_next_19;
        state->controller_plan[19] = plan_next_20;
        state->controller_worst = worst_next;
        commands->F = F;
    }
    return done;
}

unsigned ModelPredictive_step(ModelPredictive_state *state,
                              const ModelPredictive_readings *readings,
                              const ModelPredictive_references *references,
                              ModelPredictive_commands *commands)
{
    unsigned flags = (unsigned)MODELPREDICTIVE_OK;
    if (!ModelPredictive_finite(readings->x) ||
        !ModelPredictive_finite(readings->xd) ||
        !ModelPredictive_finite(readings->phi) ||
        !ModelPredictive_finite(readings->phid)) {
        flags |= (unsigned)MODELPREDICTIVE_BAD_READING;
    }
    if (!ModelPredictive_finite(references->x)) {
        flags |= (unsigned)MODELPREDICTIVE_BAD_REFERENCE;
    }
    if ((flags == 0u) && !ModelPredictive_advance(state, readings, references, commands)) {
        flags |= (unsigned)MODELPREDICTIVE_BAD_COMMAND;
    }
    if (flags != 0u) {
        commands->F = 0.0;
    }
    state->flags = flags;
    return flags;
}

void ModelPredictive_reset(ModelPredictive_state *state)
{
    state->controller_plan[0] = 0.0;
    state->controller_plan[1] = 0.0;
    state->controller_plan[2] = 0.0;
    state->controller_plan[3] = 0.0;
    state->controller_plan[4] = 0.0;
    state->controller_plan[5] = 0.0;
    state->controller_plan[6] = 0.0;
    state->controller_plan[7] = 0.0;
    state->controller_plan[8] = 0.0;
    state->controller_plan[9] = 0.0;
    state->controller_plan[10] = 0.0;
    state->controller_plan[11] = 0.0;
    state->controller_plan[12] = 0.0;
    state->controller_plan[13] = 0.0;
    state->controller_plan[14] = 0.0;
    state->controller_plan[15] = 0.0;
    state->controller_plan[16] = 0.0;
    state->controller_plan[17] = 0.0;
    state->controller_plan[18] = 0.0;
    state->controller_plan[19] = 0.0;
    state->controller_worst = 0.0;
    state->flags = 0u;
}

void ModelPredictive_init(ModelPredictive_state *state)
{
    ModelPredictive_reset(state);
}
/* control-workbench sha256:58bbbbc1e28503e532fddbc98b2589fe51f2b1aa9ed9ab32238fd1bf2e7b4369 */
