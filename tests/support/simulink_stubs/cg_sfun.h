/* A simulation of one block: its parameters and inputs from a file of doubles, its outputs as doubles to another. */

static size_t size_of(int type)
{
    return type == SS_DOUBLE ? sizeof(double) : 4;
}

static size_t allotted(port *ports, int count)
{
    size_t numbers = 0;
    for (int i = 0; i < count; ++i) {
        ss_require(ports[i].width > 0, "a port without a width");
        ports[i].signal = calloc((size_t)ports[i].width, size_of(ports[i].type));
        numbers += (size_t)ports[i].width;
    }
    return numbers;
}

static void put(port *p, int i, double value)
{
    if (p->type == SS_DOUBLE)
        ((double *)p->signal)[i] = value;
    else
        ((float *)p->signal)[i] = (float)value;
}

static double got(const port *p, int i)
{
    return p->type == SS_DOUBLE   ? ((double *)p->signal)[i]
           : p->type == SS_SINGLE ? (double)((float *)p->signal)[i]
                                  : (double)((uint32_T *)p->signal)[i];
}

/* block RESET < rows: after so many instants the states are reset. Further arguments: the parameters, width:v,v,v */
int main(int argc, char **argv)
{
    static SimStruct block;
    SimStruct *S = &block;
    const long reset = argc > 1 ? atol(argv[1]) : -1;
    S->given = argc > 2 ? argc - 2 : 0;
    for (int i = 0; i < S->given; ++i) {
        char *text = argv[i + 2];
        const size_t size = strtoul(text, &text, 10);
        double *values = calloc(size, sizeof(double));
        for (size_t j = 0; j < size; ++j)
            values[j] = strtod(text + 1, &text);
        S->parameter[i].values = values;
        S->parameter[i].size = size;
    }
    S->sizing = 1;
    mdlInitializeSizes(S);
    if (S->error) {
        fprintf(stderr, "%s\n", S->error);
        return 2;
    }
    ss_require(S->given == S->parameters, "another number of parameters");
    S->sizing = 0;
    ss_require(S->times == 1, "one sample time");
    mdlInitializeSampleTimes(S);
    const size_t numbers = allotted(S->input, S->inputs);
    allotted(S->output, S->outputs);
    allotted(S->work, S->works);
    mdlStart(S);
    mdlInitializeConditions(S);
    fprintf(stderr, "%.17g %.17g\n", S->period, S->offset);
    double *row = calloc(numbers, sizeof(double));
    for (long k = 0; fread(row, sizeof(double), numbers, stdin) == numbers; ++k) {
        if (k == reset)
            mdlInitializeConditions(S);
        S->major = 0; /* asked too early and too often, it must answer alike */
        mdlOutputs(S, 0);
        const double *next = row;
        for (int i = 0; i < S->inputs; ++i)
            for (int j = 0; j < S->input[i].width; ++j)
                put(&S->input[i], j, *next++);
        S->major = 1;
        mdlOutputs(S, 0);
        mdlOutputs(S, 0);
        mdlUpdate(S, 0);
        for (int i = 0; i < S->outputs; ++i)
            for (int j = 0; j < S->output[i].width; ++j) {
                const double value = got(&S->output[i], j);
                fwrite(&value, sizeof value, 1, stdout);
            }
    }
    mdlTerminate(S);
    return 0;
}
