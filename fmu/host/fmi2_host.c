/*
 * Test host for an FMI 2.0 co-simulation FMU library (see README.md).
 *
 *   fmi2_host MODE LIBRARY RESOURCE_URI GUID VARIABLES [extra...]
 *
 * Exit code: 0 nothing failed, 1 something failed, 2 bad usage.
 */
#define _XOPEN_SOURCE 700

#include <ctype.h>
#include <dirent.h>
#include <dlfcn.h>
#include <errno.h>
#include <fenv.h>
#include <float.h>
#include <ftw.h>
#include <math.h>
#include <pthread.h>
#include <signal.h>
#include <stdarg.h>
#include <stdatomic.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <time.h>
#include <unistd.h>

#include "fmi2Functions.h"

/* ------------------------------------------------------------------ */
/* The functions of the library                                        */

#define FMI_FUNCTIONS(X)                                                     \
    X(GetTypesPlatform) X(GetVersion) X(SetDebugLogging)                     \
    X(Instantiate) X(FreeInstance)                                           \
    X(SetupExperiment) X(EnterInitializationMode) X(ExitInitializationMode)  \
    X(Terminate) X(Reset)                                                    \
    X(GetReal) X(GetInteger) X(GetBoolean) X(GetString)                      \
    X(SetReal) X(SetInteger) X(SetBoolean) X(SetString)                      \
    X(GetFMUstate) X(SetFMUstate) X(FreeFMUstate)                            \
    X(SerializedFMUstateSize) X(SerializeFMUstate) X(DeSerializeFMUstate)    \
    X(GetDirectionalDerivative)                                              \
    X(EnterEventMode) X(NewDiscreteStates) X(EnterContinuousTimeMode)        \
    X(CompletedIntegratorStep) X(SetTime) X(SetContinuousStates)             \
    X(GetDerivatives) X(GetEventIndicators) X(GetContinuousStates)           \
    X(GetNominalsOfContinuousStates)                                         \
    X(SetRealInputDerivatives) X(GetRealOutputDerivatives)                   \
    X(DoStep) X(CancelStep)                                                  \
    X(GetStatus) X(GetRealStatus) X(GetIntegerStatus) X(GetBooleanStatus)    \
    X(GetStringStatus)

static struct {
#define X(n) fmi2##n##TYPE *n;
    FMI_FUNCTIONS(X)
#undef X
} L;

/* ------------------------------------------------------------------ */
/* Reporting                                                           */

static long g_ok, g_fail;
static const char *volatile g_doing = "start";
static const unsigned ALARM_SECONDS = 900;

static char *vfmtdup(const char *f, va_list ap)
{
    va_list ap2;
    va_copy(ap2, ap);
    int n = vsnprintf(NULL, 0, f, ap2);
    va_end(ap2);
    char *s = malloc(n < 0 ? 1 : (size_t)n + 1);
    if (!s) { perror("malloc"); exit(1); }
    s[0] = 0;
    if (n >= 0) vsnprintf(s, (size_t)n + 1, f, ap);
    return s;
}

static char *fmtdup(const char *f, ...) __attribute__((format(printf, 1, 2)));
static char *fmtdup(const char *f, ...)
{
    va_list ap;
    va_start(ap, f);
    char *s = vfmtdup(f, ap);
    va_end(ap);
    return s;
}

static void *xalloc(size_t n, size_t size)
{
    void *p = calloc(n ? n : 1, size);
    if (!p) { perror("calloc"); exit(1); }
    return p;
}

/* Names what runs now, for the report of a crash or a hang. */
static void mark(const char *name)
{
    g_doing = name;
    alarm(ALARM_SECONDS);
}

/* One check; the text says what was expected and what came. */
static int ck(int ok, const char *name, const char *f, ...)
    __attribute__((format(printf, 3, 4)));
static int ck(int ok, const char *name, const char *f, ...)
{
    if (ok) {
        g_ok++;
        printf("ok %s\n", name);
    } else {
        va_list ap;
        va_start(ap, f);
        char *s = vfmtdup(f, ap);
        va_end(ap);
        g_fail++;
        printf("FAIL %s: %s\n", name, s);
        free(s);
    }
    return ok;
}

static void note(const char *f, ...) __attribute__((format(printf, 1, 2)));
static void note(const char *f, ...)
{
    va_list ap;
    va_start(ap, f);
    fputs("note ", stdout);
    vprintf(f, ap);
    putchar('\n');
    va_end(ap);
}

static const char *stname(fmi2Status s)
{
    static const char *const n[] = { "fmi2OK", "fmi2Warning", "fmi2Discard",
                                     "fmi2Error", "fmi2Fatal", "fmi2Pending" };
    return (int)s >= 0 && (int)s < 6 ? n[s] : "an undefined status";
}

static void on_signal(int sig)
{
    const char *what = g_doing;
    const char *kind = sig == SIGALRM ? "FAIL hang in " : "FAIL crash in ";
    const char *tail = sig == SIGALRM ? ": an answer was expected, none came\n"
                                      : ": a status was expected, a signal came\n";
    ssize_t r = write(1, kind, strlen(kind));
    r = write(1, what, strlen(what));
    r = write(1, tail, strlen(tail));
    (void)r;
    _exit(1);
}

/* ------------------------------------------------------------------ */
/* Variables                                                           */

enum vtype { T_REAL, T_INTEGER, T_BOOLEAN, T_STRING, T_COUNT };
static const char *const TYPE_NAMES[] = { "Real", "Integer", "Boolean", "String" };

struct var {
    char *name;
    fmi2ValueReference vr;
    enum vtype type;
    char causality[32];
};

static struct var *g_vars;
static size_t g_nvars;
static fmi2ValueReference *g_out_vr; /* Real outputs, in file order */
static const char **g_out_name;
static size_t g_nout;

enum key {
    K_TORQUE, K_LATERAL, K_VERTICAL, K_MU_L, K_MU_R,
    K_DISTANCE, K_Y, K_Z, K_ROLL, K_YAW, K_PITCHRATE, K_VY, K_YAWRATE, K_AY,
    K_QL, K_NL, K_NR, K_PEN, K_MASS, K_IY, K_EQUILIBRIUM, K_COUNT
};

static const struct { const char *name; enum vtype type; const char *causality; } KNOWN[K_COUNT] = {
    { "wheelset.driveTorque", T_REAL, "input" },
    { "wheelset.lateralForceInput", T_REAL, "input" },
    { "wheelset.verticalForceInput", T_REAL, "input" },
    { "wheelset.left.frictionFactor", T_REAL, "input" },
    { "wheelset.right.frictionFactor", T_REAL, "input" },
    { "wheelset.distance", T_REAL, "output" },
    { "wheelset.y", T_REAL, "output" },
    { "wheelset.z", T_REAL, "output" },
    { "wheelset.roll", T_REAL, "output" },
    { "wheelset.yaw", T_REAL, "output" },
    { "wheelset.pitchRate", T_REAL, "output" },
    { "wheelset.vy", T_REAL, "output" },
    { "wheelset.yawRate", T_REAL, "output" },
    { "wheelset.ay", T_REAL, "output" },
    { "wheelset.left.verticalForce", T_REAL, "output" },
    { "wheelset.left.normalForce", T_REAL, "output" },
    { "wheelset.right.normalForce", T_REAL, "output" },
    { "wheelset.left.contact[1].penetration", T_REAL, "output" },
    { "wheelset.mass", T_REAL, "parameter" },
    { "wheelset.initial.y", T_REAL, "parameter" },
    { "wheelset.initial.fromEquilibrium", T_BOOLEAN, "parameter" },
};
static fmi2ValueReference g_key[K_COUNT];

static const struct var *find_var(const char *name)
{
    for (size_t i = 0; i < g_nvars; i++)
        if (!strcmp(g_vars[i].name, name)) return &g_vars[i];
    return NULL;
}

static int vr_used(fmi2ValueReference vr, int type) /* type < 0: any */
{
    for (size_t i = 0; i < g_nvars; i++)
        if (g_vars[i].vr == vr && (type < 0 || (int)g_vars[i].type == type)) return 1;
    return 0;
}

static void free_vars(void)
{
    for (size_t i = 0; i < g_nvars; i++) free(g_vars[i].name);
    free(g_vars);
    free(g_out_vr);
    free(g_out_name);
}

/* Lines 'name valueReference type causality'; 0 on success. */
static int load_vars(const char *file)
{
    FILE *f = fopen(file, "r");
    if (!f) { perror(file); return -1; }
    char line[1024];
    size_t cap = 0, no = 0;
    while (fgets(line, sizeof line, f)) {
        no++;
        char name[512], vr[32], type[32], caus[32];
        int n = sscanf(line, "%511s %31s %31s %31s", name, vr, type, caus);
        if (n <= 0 || name[0] == '#') continue;
        char *end = NULL;
        unsigned long v = n == 4 ? strtoul(vr, &end, 10) : 0;
        int t = 0;
        while (t < T_COUNT && (n != 4 || strcmp(type, TYPE_NAMES[t]))) t++;
        if (n != 4 || *end || t == T_COUNT) {
            fprintf(stderr, "%s:%zu: not 'name valueReference type causality'\n", file, no);
            fclose(f);
            return -1;
        }
        if (g_nvars == cap) {
            cap = cap ? 2 * cap : 64;
            struct var *p = realloc(g_vars, cap * sizeof *p);
            if (!p) { perror("realloc"); exit(1); }
            g_vars = p;
        }
        struct var *x = &g_vars[g_nvars++];
        x->name = fmtdup("%s", name);
        x->vr = (fmi2ValueReference)v;
        x->type = (enum vtype)t;
        memcpy(x->causality, caus, sizeof caus);
    }
    fclose(f);
    g_out_vr = xalloc(g_nvars, sizeof *g_out_vr);
    g_out_name = xalloc(g_nvars, sizeof *g_out_name);
    for (size_t i = 0; i < g_nvars; i++)
        if (g_vars[i].type == T_REAL && !strcmp(g_vars[i].causality, "output")) {
            g_out_vr[g_nout] = g_vars[i].vr;
            g_out_name[g_nout++] = g_vars[i].name;
        }
    if (!g_nout) { fprintf(stderr, "%s: no Real output\n", file); return -1; }
    return 0;
}

/* The names the modes rely on. */
static int check_known(int quiet)
{
    int all = 1;
    for (int k = 0; k < K_COUNT; k++) {
        const struct var *v = find_var(KNOWN[k].name);
        int good = v && v->type == KNOWN[k].type && !strcmp(v->causality, KNOWN[k].causality);
        if (good) g_key[k] = v->vr;
        if (!good || !quiet) {
            char *n = fmtdup("variable %s", KNOWN[k].name);
            ck(good, n, "expected a %s %s, came %s %s", TYPE_NAMES[KNOWN[k].type],
               KNOWN[k].causality, v ? TYPE_NAMES[v->type] : "none", v ? v->causality : "");
            free(n);
        }
        all &= good;
    }
    return all;
}

/* ------------------------------------------------------------------ */
/* Callbacks                                                           */

#define MAX_ENVS 512

struct env {
    int used;
    fmi2CallbackFunctions cb;
    const char *name; /* expected instance name, NULL: any */
    long messages;    /* all */
    long sentences;   /* non-empty, with a status other than fmi2OK */
    char last[1024];
};

static struct env g_envs[MAX_ENVS];
static pthread_mutex_t g_env_lock = PTHREAD_MUTEX_INITIALIZER;
static atomic_long g_bad_env, g_bad_name, g_stray, g_percents, g_bad_category, g_bad_message, g_stale,
    g_step_finished, g_allocs, g_frees;
static char g_stray_text[256], g_category_text[128];
static char **g_categories; /* known log categories, abi mode */
static int g_ncategories;
static int g_verbose;

static int is_sentence(const char *s)
{
    int letter = 0, space = 0;
    for (; *s; s++) {
        letter |= isalpha((unsigned char)*s);
        space |= *s == ' ';
    }
    return letter && space;
}

static void host_logger(fmi2ComponentEnvironment ce, fmi2String name, fmi2Status status,
                        fmi2String category, fmi2String message, ...)
{
    struct env *e = NULL;
    for (int i = 0; i < MAX_ENVS; i++)
        if (ce == &g_envs[i] && g_envs[i].used) e = &g_envs[i];
    if (!e) { g_bad_env++; return; }
    if (e->name && (!name || strcmp(name, e->name))) g_bad_name++;

    int known = category && !g_ncategories;
    for (int i = 0; category && i < g_ncategories; i++) known |= !strcmp(category, g_categories[i]);
    if (!known) {
        if (!g_bad_category++)
            snprintf(g_category_text, sizeof g_category_text, "%s", category ? category : "NULL");
    }
    if (!message || (int)status < 0 || (int)status > 5) { g_bad_message++; return; }

    int stray = 0;
    for (const char *p = message; *p; p++)
        if (*p == '%') {
            if (p[1] == '%') p++;
            else stray = 1;
        }
    if (stray) {
        if (!g_stray++) snprintf(g_stray_text, sizeof g_stray_text, "%s", message);
        snprintf(e->last, sizeof e->last, "%s", message);
    } else {
        va_list ap;
        va_start(ap, message);
        vsnprintf(e->last, sizeof e->last, message, ap);
        va_end(ap);
    }
    e->messages++;
    if (status != fmi2OK && is_sentence(e->last)) e->sentences++;
    if (strchr(e->last, '%')) g_percents++;
    if (g_verbose)
        fprintf(stderr, "log [%s] %s %s: %s\n", name ? name : "NULL", stname(status),
                category ? category : "NULL", e->last);
}

static void stale_logger(fmi2ComponentEnvironment ce, fmi2String name, fmi2Status status,
                         fmi2String category, fmi2String message, ...)
{
    (void)ce; (void)name; (void)status; (void)category; (void)message;
    g_stale++;
}

static void *host_alloc(size_t n, size_t size)
{
    void *p = calloc(n, size);
    if (p) g_allocs++;
    return p;
}

static void *no_alloc(size_t n, size_t size)
{
    (void)n; (void)size;
    return NULL;
}

static void host_free(void *p)
{
    if (p) g_frees++;
    free(p);
}

static void host_step_finished(fmi2ComponentEnvironment ce, fmi2Status s)
{
    (void)ce; (void)s;
    g_step_finished++;
}

static struct env *env_new(const char *name)
{
    pthread_mutex_lock(&g_env_lock);
    struct env *e = NULL;
    for (int i = 0; i < MAX_ENVS && !e; i++)
        if (!g_envs[i].used) e = &g_envs[i];
    if (!e) { fprintf(stderr, "too many instances\n"); exit(1); }
    memset(e, 0, sizeof *e);
    e->used = 1;
    pthread_mutex_unlock(&g_env_lock);
    e->name = name;
    e->cb.logger = host_logger;
    e->cb.allocateMemory = host_alloc;
    e->cb.freeMemory = host_free;
    e->cb.stepFinished = host_step_finished;
    e->cb.componentEnvironment = e;
    return e;
}

static void env_free(struct env *e)
{
    pthread_mutex_lock(&g_env_lock);
    e->used = 0;
    pthread_mutex_unlock(&g_env_lock);
}

/* ------------------------------------------------------------------ */
/* Instances                                                           */

static const char *g_uri, *g_guid;

struct inst {
    fmi2Component c;
    struct env *e;
    double t;
};

/* Parameters, inputs and experiment of a run. */
struct scen {
    double y0, torque, lateral, mu;
    double start, stop, tolerance;
    int has_stop, has_tolerance;
    int defaults; /* set nothing */
};

static const struct scen PLAIN = { .y0 = 1e-3, .torque = 500.0, .lateral = 2000.0, .mu = 0.9 };
static const struct scen UNTOUCHED = { .defaults = 1 };

/* The strings are gone after the call: the library must copy them. */
static fmi2Component instantiate(struct env *e, const char *name, fmi2Type type, const char *guid,
                                 const char *uri, int logging)
{
    char *n = name ? fmtdup("%s", name) : NULL, *g = guid ? fmtdup("%s", guid) : NULL,
         *u = uri ? fmtdup("%s", uri) : NULL;
    fmi2Component c = L.Instantiate(n, type, g, u, &e->cb, fmi2False, logging);
    if (n) memset(n, '?', strlen(n));
    free(n);
    free(g);
    free(u);
    return c;
}

static int inst_open_at(struct inst *in, const char *name, const char *uri)
{
    in->e = env_new(name);
    in->t = 0;
    in->c = instantiate(in->e, name, fmi2CoSimulation, g_guid, uri, fmi2True);
    if (!in->c) { env_free(in->e); in->e = NULL; }
    return in->c != NULL;
}

static int inst_open(struct inst *in, const char *name) { return inst_open_at(in, name, g_uri); }

static void inst_close(struct inst *in)
{
    if (in->c) L.FreeInstance(in->c);
    if (in->e) env_free(in->e);
    in->c = NULL;
    in->e = NULL;
}

static fmi2Status set1(struct inst *in, enum key k, double v)
{
    return L.SetReal(in->c, &g_key[k], 1, &v);
}

static double get1(struct inst *in, enum key k)
{
    double v = NAN;
    if (L.GetReal(in->c, &g_key[k], 1, &v) != fmi2OK) return NAN;
    return v;
}

static fmi2Status worse(fmi2Status a, fmi2Status b) { return a > b ? a : b; }

/* a, then b if a was fmi2OK; the order is certain, unlike with arguments. */
static _Thread_local fmi2Status t_status;
#define THEN(a, b) ((t_status = (a)) != fmi2OK ? t_status : (b))

static fmi2Status set_parameters(struct inst *in, const struct scen *s)
{
    return s->defaults ? fmi2OK : set1(in, K_IY, s->y0);
}

static fmi2Status set_inputs(struct inst *in, const struct scen *s)
{
    if (s->defaults) return fmi2OK;
    fmi2ValueReference vr[4] = { g_key[K_TORQUE], g_key[K_LATERAL], g_key[K_MU_L], g_key[K_MU_R] };
    double v[4] = { s->torque, s->lateral, s->mu, s->mu };
    return L.SetReal(in->c, vr, 4, v);
}

static fmi2Status setup(struct inst *in, const struct scen *s)
{
    in->t = s->start;
    return L.SetupExperiment(in->c, s->has_tolerance, s->tolerance, s->start, s->has_stop, s->stop);
}

/* From instantiated to step mode. */
static fmi2Status start(struct inst *in, const struct scen *s)
{
    fmi2Status st = set_parameters(in, s);
    st = THEN(st, setup(in, s));
    st = THEN(st, L.EnterInitializationMode(in->c));
    st = THEN(st, set_inputs(in, s));
    return THEN(st, L.ExitInitializationMode(in->c));
}

static fmi2Status step(struct inst *in, double h)
{
    fmi2Status st = L.DoStep(in->c, in->t, h, fmi2True);
    if (st == fmi2OK) in->t += h;
    return st;
}

static fmi2Status outputs(struct inst *in, double *v)
{
    memset(v, 0, g_nout * sizeof *v);
    return L.GetReal(in->c, g_out_vr, g_nout, v);
}

static int same(const double *a, const double *b, size_t rows)
{
    return !memcmp(a, b, rows * g_nout * sizeof *a);
}

/* Text of the first differing value. */
static char *difference(const double *got, const double *want, size_t rows)
{
    for (size_t i = 0; i < rows * g_nout; i++)
        if (memcmp(&got[i], &want[i], sizeof *got))
            return fmtdup("row %zu %s: expected %a, came %a", i / g_nout, g_out_name[i % g_nout],
                          want[i], got[i]);
    return fmtdup("no difference");
}

/* n steps of h; row 0 of the trace (n + 1 rows) is the start. */
static fmi2Status run(struct inst *in, size_t n, double h, double *trace)
{
    fmi2Status st = outputs(in, trace);
    for (size_t i = 0; i < n && st == fmi2OK; i++) {
        st = step(in, h);
        if (st == fmi2OK) st = outputs(in, trace + (i + 1) * g_nout);
    }
    return st;
}

static int ck_status(const char *name, fmi2Status want, fmi2Status got)
{
    return ck(want == got, name, "expected %s, came %s", stname(want), stname(got));
}

static int ck_same(const char *name, fmi2Status st, const double *got, const double *want,
                   size_t rows)
{
    if (st != fmi2OK) return ck_status(name, fmi2OK, st);
    char *d = difference(got, want, rows);
    int ok = ck(same(got, want, rows), name, "%s", d);
    free(d);
    return ok;
}

static int refused(fmi2Status st) { return st == fmi2Error || st == fmi2Discard; }

/* ------------------------------------------------------------------ */
/* Files and URIs                                                      */

static int hexval(int c)
{
    return c >= '0' && c <= '9' ? c - '0'
         : c >= 'a' && c <= 'f' ? c - 'a' + 10
         : c >= 'A' && c <= 'F' ? c - 'A' + 10 : -1;
}

static char *uri_to_path(const char *u)
{
    if (!strncmp(u, "file:", 5)) u += 5;
    if (u[0] == '/' && u[1] == '/') {
        u += 2;
        while (*u && *u != '/') u++;
    }
    char *p = xalloc(strlen(u) + 2, 1), *q = p;
    for (; *u; u++) {
        if (*u == '%' && u[1] && hexval(u[1]) >= 0 && hexval(u[2]) >= 0) {
            *q++ = (char)(16 * hexval(u[1]) + hexval(u[2]));
            u += 2;
        } else {
            *q++ = *u;
        }
    }
    while (q > p + 1 && q[-1] == '/') *--q = 0;
    return p;
}

/* prefix + percent-encoded path */
static char *path_to_uri(const char *prefix, const char *path, int lower)
{
    size_t n = strlen(prefix);
    char *u = xalloc(n + 3 * strlen(path) + 1, 1), *q = u + n;
    memcpy(u, prefix, n);
    for (; *path; path++) {
        unsigned char c = (unsigned char)*path;
        if (isalnum(c) || strchr("/-._~", c)) *q++ = (char)c;
        else q += sprintf(q, lower ? "%%%02x" : "%%%02X", c);
    }
    return u;
}

static char *temp_dir(void)
{
    const char *base = getenv("TMPDIR");
    char *d = fmtdup("%s/fmi2_host_XXXXXX", base && *base ? base : "/tmp");
    if (!mkdtemp(d)) { perror(d); exit(1); }
    return d;
}

static int rm_one(const char *p, const struct stat *s, int flag, struct FTW *f)
{
    (void)s; (void)flag; (void)f;
    return remove(p);
}

static void remove_tree(const char *p) { nftw(p, rm_one, 16, FTW_DEPTH | FTW_PHYS); }

static char *read_all(const char *file, size_t *n)
{
    FILE *f = fopen(file, "rb");
    if (!f) return NULL;
    size_t cap = 65536;
    char *b = malloc(cap);
    *n = 0;
    while (b) {
        *n += fread(b + *n, 1, cap - *n, f);
        if (*n < cap) break;
        cap *= 2;
        char *b2 = realloc(b, cap);
        if (!b2) free(b);
        b = b2;
    }
    fclose(f);
    return b;
}

static int write_all(const char *file, const char *b, size_t n)
{
    FILE *f = fopen(file, "wb");
    if (!f) return -1;
    size_t w = fwrite(b, 1, n, f);
    return fclose(f) || w != n ? -1 : 0;
}

/* Copies a folder recursively; 0 on success. */
static int copy_tree(const char *from, const char *to)
{
    if (mkdir(to, 0700) && errno != EEXIST) return -1;
    DIR *d = opendir(from);
    if (!d) return -1;
    int r = 0;
    for (struct dirent *e; !r && (e = readdir(d));) {
        if (!strcmp(e->d_name, ".") || !strcmp(e->d_name, "..")) continue;
        char *a = fmtdup("%s/%s", from, e->d_name), *b = fmtdup("%s/%s", to, e->d_name);
        struct stat s;
        if (stat(a, &s)) r = -1;
        else if (S_ISDIR(s.st_mode)) r = copy_tree(a, b);
        else if (S_ISREG(s.st_mode)) {
            size_t n = 0;
            char *t = read_all(a, &n);
            r = t ? write_all(b, t, n) : -1;
            free(t);
        }
        free(a);
        free(b);
    }
    closedir(d);
    return r;
}

/* ------------------------------------------------------------------ */
/* Checks on what the callbacks saw, at the end of every mode          */

static void callback_checks(void)
{
    mark("callbacks");
    ck(!g_bad_env, "callbacks.environment", "expected the componentEnvironment unchanged, came %ld others",
       (long)g_bad_env);
    ck(!g_bad_name, "callbacks.instance-name", "expected the instance name in each message, came %ld others",
       (long)g_bad_name);
    ck(!g_stray, "callbacks.percent-signs", "expected every percent sign doubled, came %ld messages like '%s'",
       (long)g_stray, g_stray_text);
    ck(!g_bad_category, "callbacks.category", "expected a category of the list, came %ld like '%s'",
       (long)g_bad_category, g_category_text);
    ck(!g_bad_message, "callbacks.message", "expected a message and a status in each call, came %ld without",
       (long)g_bad_message);
    ck(!g_stale, "callbacks.copied", "expected the callbacks given at instantiation, came %ld calls of others",
       (long)g_stale);
    ck(!g_step_finished, "callbacks.step-finished", "expected no call, came %ld", (long)g_step_finished);
    ck(g_allocs == g_frees, "callbacks.memory", "expected as many frees as allocations (%ld), came %ld",
       (long)g_allocs, (long)g_frees);
}

/* ------------------------------------------------------------------ */
/* abi                                                                 */

static int all_finite(const double *v, size_t n)
{
    for (size_t i = 0; i < n; i++)
        if (!isfinite(v[i])) return 0;
    return 1;
}

static void abi_lifecycle(void)
{
    enum { N = 100 };
    double *a = xalloc((N + 1) * g_nout, sizeof *a), *b = xalloc((N + 1) * g_nout, sizeof *b);
    struct inst in, other;

    for (int k = 0; k < 4; k++) {
        struct scen s = PLAIN;
        s.has_stop = k & 1;
        s.stop = 1.0;
        s.has_tolerance = k >> 1;
        s.tolerance = 1e-6;
        static const char *const names[] = { "abi.run.plain", "abi.run.stop", "abi.run.tolerance",
                                             "abi.run.stop+tolerance" };
        mark(names[k]);
        if (!ck(inst_open(&in, "wheelset 1"), names[k], "expected an instance, came NULL")) continue;
        fmi2Status st = THEN(start(&in, &s), run(&in, N, 0.01, a));
        ck_status(names[k], fmi2OK, st);
        ck(all_finite(a, (N + 1) * g_nout), names[k], "expected finite outputs, came others");
        ck_status("abi.terminate", fmi2OK, L.Terminate(in.c));
        if (k == 0) {
            mark("abi.reset");
            ck_status("abi.reset.after-terminate", fmi2OK, L.Reset(in.c));
            st = THEN(start(&in, &s), run(&in, N, 0.01, b));
            ck_same("abi.reset.again", st, b, a, N + 1);
            ck_status("abi.reset.while-stepping", fmi2OK, L.Reset(in.c));
            st = THEN(start(&in, &s), run(&in, N, 0.01, b));
            ck_same("abi.reset.again2", st, b, a, N + 1);

            /* after a reset all start values hold again */
            ck_status("abi.reset.3", fmi2OK, L.Reset(in.c));
            st = THEN(start(&in, &UNTOUCHED), run(&in, N, 0.01, b));
            if (inst_open(&other, "wheelset 2")) {
                fmi2Status st2 = THEN(start(&other, &UNTOUCHED), run(&other, N, 0.01, a));
                ck_same("abi.reset.start-values", worse(st, st2), b, a, N + 1);
                ck_status("abi.run.defaults", fmi2OK, st2);
                ck(all_finite(a, (N + 1) * g_nout), "abi.run.defaults", "expected finite outputs");
                inst_close(&other);
            }
            ck_status("abi.reset.4", fmi2OK, L.Reset(in.c));
            set_parameters(&in, &s);
            setup(&in, &s);
            L.EnterInitializationMode(in.c);
            ck_status("abi.reset.in-initialization", fmi2OK, L.Reset(in.c));
            st = THEN(start(&in, &UNTOUCHED), run(&in, N, 0.01, b));
            ck_same("abi.reset.again3", st, b, a, N + 1);
        }
        inst_close(&in);
    }

    /* free in each state of the life cycle */
    mark("abi.free");
    for (int k = 0; k < 5; k++) {
        if (!inst_open(&in, "freed")) continue;
        if (k > 0) setup(&in, &PLAIN);
        if (k > 1) L.EnterInitializationMode(in.c);
        if (k > 2) L.ExitInitializationMode(in.c);
        if (k > 3) step(&in, 0.01);
        inst_close(&in);
    }
    ck(1, "abi.free", " ");

    /* time as i*h, and the flag the other way round, give the same */
    mark("abi.time-product");
    if (inst_open(&in, "wheelset 3")) {
        fmi2Status st = THEN(start(&in, &PLAIN), run(&in, N, 0.01, a));
        inst_close(&in);
        if (inst_open(&in, "wheelset 4")) {
            st = THEN(st, start(&in, &PLAIN));
            for (int i = 0; i < N; i++) st = THEN(st, L.DoStep(in.c, i * 0.01, 0.01, fmi2False));
            ck_status("abi.time-product", fmi2OK, st);
            outputs(&in, b);
            int near = 1;
            for (size_t i = 0; i < g_nout; i++) {
                double w = a[N * g_nout + i];
                near &= fabs(b[i] - w) <= 1e-6 * (1 + fabs(w));
            }
            ck(near, "abi.time-product.outputs", "expected the outputs of the plain run within 1e-6, came others");
            inst_close(&in);
        }
    }

    mark("abi.start-time");
    if (inst_open(&in, "wheelset 5")) {
        struct scen s = PLAIN;
        s.start = 0.25;
        fmi2Status st = THEN(start(&in, &s), run(&in, 10, 0.01, a));
        ck_status("abi.start-time", fmi2OK, st);
        double t = NAN;
        st = L.GetRealStatus(in.c, fmi2LastSuccessfulTime, &t);
        ck(st == fmi2OK && fabs(t - in.t) < 1e-9, "abi.start-time.last-successful-time",
           "expected %.17g, came %.17g with %s", in.t, t, stname(st));
        inst_close(&in);
    }
    free(a);
    free(b);
}

/* Sense of the values, roughly. */
static void abi_values(void)
{
    double *a = xalloc(101 * g_nout, sizeof *a), *b = xalloc(101 * g_nout, sizeof *b);
    struct inst in, off;
    mark("abi.values");
    if (inst_open(&in, "default") && inst_open(&off, "offset")) {
        struct scen s = UNTOUCHED;
        s.defaults = 0;
        s.y0 = 1e-3;
        fmi2Status st = THEN(start(&in, &UNTOUCHED), set_parameters(&off, &s));
        st = THEN(st, setup(&off, &s));
        st = THEN(st, L.EnterInitializationMode(off.c));
        st = THEN(st, L.ExitInitializationMode(off.c));
        ck_status("abi.values.start", fmi2OK, st);
        double d = get1(&off, K_Y) - get1(&in, K_Y);
        ck(fabs(d - 1e-3) < 1e-9, "abi.values.offset", "expected y to start 1e-3 beside the equilibrium, came %.17g", d);
        fmi2Boolean eq = -1;
        st = L.GetBoolean(in.c, &g_key[K_EQUILIBRIUM], 1, &eq);
        ck(st == fmi2OK && eq == fmi2True, "abi.values.fromEquilibrium", "expected 1, came %d with %s", eq, stname(st));
        ck(get1(&in, K_QL) > 1e3, "abi.values.load", "expected a wheel load above 1 kN, came %g", get1(&in, K_QL));
        ck(get1(&in, K_MASS) > 0, "abi.values.mass", "expected a positive mass, came %g", get1(&in, K_MASS));
        double x0 = get1(&in, K_DISTANCE);
        st = run(&in, 100, 0.01, a);
        double x = get1(&in, K_DISTANCE) - x0;
        ck(st == fmi2OK && fabs(x - 40) < 2, "abi.values.distance", "expected about 40 m in 1 s, came %g with %s", x, stname(st));

        /* every variable can be read in step mode */
        for (int t = 0; t < T_COUNT; t++) {
            size_t bad = 0, n = 0;
            const char *first = "";
            for (size_t i = 0; i < g_nvars; i++) {
                if ((int)g_vars[i].type != t) continue;
                double r = 0;
                fmi2Integer k = 0;
                fmi2Boolean o = 0;
                fmi2String s1 = "";
                fmi2ValueReference vr = g_vars[i].vr;
                fmi2Status q = t == T_REAL ? L.GetReal(in.c, &vr, 1, &r)
                             : t == T_INTEGER ? L.GetInteger(in.c, &vr, 1, &k)
                             : t == T_BOOLEAN ? L.GetBoolean(in.c, &vr, 1, &o)
                             : L.GetString(in.c, &vr, 1, &s1);
                n++;
                if (q != fmi2OK || !isfinite(r) || (o != 0 && o != 1) || !s1)
                    if (!bad++) first = g_vars[i].name;
            }
            char *name = fmtdup("abi.values.read-%s", TYPE_NAMES[t]);
            ck(!bad, name, "expected %zu readable finite values, came %zu others, first %s", n, bad, first);
            free(name);
        }
    } else {
        ck(0, "abi.values", "expected two instances, came NULL");
    }
    inst_close(&in);
    inst_close(&off);

    /* a parameter may be set before or in initialization mode */
    mark("abi.values.parameter-mode");
    if (inst_open(&in, "before") && inst_open(&off, "within")) {
        fmi2Status st = THEN(start(&in, &PLAIN), setup(&off, &PLAIN));
        st = THEN(st, L.EnterInitializationMode(off.c));
        st = THEN(st, set_parameters(&off, &PLAIN));
        st = THEN(st, set_inputs(&off, &PLAIN));
        st = THEN(st, L.ExitInitializationMode(off.c));
        st = THEN(st, THEN(run(&in, 10, 0.01, a), run(&off, 10, 0.01, b)));
        ck_same("abi.values.parameter-mode", st, b, a, 11);
    }
    inst_close(&in);
    inst_close(&off);

    mark("abi.values.floating-point");
    if (inst_open(&in, "fpu")) {
        start(&in, &PLAIN);
        run(&in, 3, 0.01, a);
        volatile double tiny = DBL_MIN;
        tiny /= 2;
        ck(fegetround() == FE_TONEAREST && tiny > 0, "abi.values.floating-point",
           "expected rounding to nearest with subnormals, came another mode");
        inst_close(&in);
    }
    free(a);
    free(b);
}

static void abi_model_exchange(struct inst *in)
{
    fmi2EventInfo info;
    fmi2Boolean b1 = 0, b2 = 0;
    double x[32] = { 0 };
    long s0;
    fmi2Status st;
#define ME(nm, expr)                                                                   \
    mark("abi.model-exchange." nm);                                                    \
    s0 = in->e->sentences;                                                             \
    st = (expr);                                                                       \
    ck_status("abi.model-exchange." nm, fmi2Error, st);                                \
    ck(in->e->sentences > s0, "abi.model-exchange." nm ".log", "expected a sentence, came none");
    ME("EnterEventMode", L.EnterEventMode(in->c))
    ME("NewDiscreteStates", L.NewDiscreteStates(in->c, &info))
    ME("EnterContinuousTimeMode", L.EnterContinuousTimeMode(in->c))
    ME("CompletedIntegratorStep", L.CompletedIntegratorStep(in->c, fmi2True, &b1, &b2))
    ME("SetTime", L.SetTime(in->c, 0.0))
    ME("SetContinuousStates", L.SetContinuousStates(in->c, x, 4))
    ME("GetDerivatives", L.GetDerivatives(in->c, x, 4))
    ME("GetEventIndicators", L.GetEventIndicators(in->c, x, 4))
    ME("GetContinuousStates", L.GetContinuousStates(in->c, x, 4))
    ME("GetNominalsOfContinuousStates", L.GetNominalsOfContinuousStates(in->c, x, 4))
#undef ME
}

static void abi_status(struct inst *in)
{
    fmi2Status s = fmi2OK, st;
    fmi2Real r = NAN;
    fmi2Integer i = 0;
    fmi2Boolean b = 0;
    fmi2String t = "";
    mark("abi.status");
    st = L.GetRealStatus(in->c, fmi2LastSuccessfulTime, &r);
    ck(st == fmi2OK && fabs(r - in->t) < 1e-9, "abi.status.LastSuccessfulTime", "expected %.17g, came %.17g with %s",
       in->t, r, stname(st));
    st = L.GetBooleanStatus(in->c, fmi2Terminated, &b);
    ck(refused(st) || (st == fmi2OK && b == fmi2False), "abi.status.Terminated", "expected false or a refusal, came %d with %s", b, stname(st));
    st = L.GetStatus(in->c, fmi2DoStepStatus, &s);
    ck(refused(st) || (st == fmi2OK && s == fmi2OK), "abi.status.DoStepStatus", "expected fmi2OK or a refusal, came %s with %s", stname(s), stname(st));
    st = L.GetStringStatus(in->c, fmi2PendingStatus, &t);
    ck(refused(st) || (st == fmi2OK && t), "abi.status.PendingStatus", "expected a text or a refusal, came %s", stname(st));
    st = L.GetRealStatus(in->c, fmi2DoStepStatus, &r);
    ck(refused(st), "abi.status.real-of-other", "expected a refusal, came %s", stname(st));
    st = L.GetBooleanStatus(in->c, fmi2LastSuccessfulTime, &b);
    ck(refused(st), "abi.status.boolean-of-other", "expected a refusal, came %s", stname(st));
    st = L.GetStatus(in->c, fmi2LastSuccessfulTime, &s);
    ck(refused(st), "abi.status.status-of-other", "expected a refusal, came %s", stname(st));
    st = L.GetIntegerStatus(in->c, fmi2LastSuccessfulTime, &i);
    ck(refused(st), "abi.status.integer", "expected a refusal, came %s", stname(st));
    st = L.GetStringStatus(in->c, fmi2Terminated, &t);
    ck(refused(st), "abi.status.string-of-other", "expected a refusal, came %s", stname(st));
    volatile int odd = 77; /* outside of the enumeration */
    st = L.GetRealStatus(in->c, (fmi2StatusKind)odd, &r);
    ck(refused(st), "abi.status.unknown-kind", "expected a refusal, came %s", stname(st));
    mark("abi.cancelStep");
    st = L.CancelStep(in->c);
    ck(refused(st), "abi.cancelStep", "expected fmi2Error or fmi2Discard, came %s", stname(st));
}

static void abi_nothing(struct inst *in)
{
    mark("abi.nothing");
    ck_status("abi.nothing.getReal", fmi2OK, L.GetReal(in->c, NULL, 0, NULL));
    ck_status("abi.nothing.getInteger", fmi2OK, L.GetInteger(in->c, NULL, 0, NULL));
    ck_status("abi.nothing.getBoolean", fmi2OK, L.GetBoolean(in->c, NULL, 0, NULL));
    ck_status("abi.nothing.getString", fmi2OK, L.GetString(in->c, NULL, 0, NULL));
    ck_status("abi.nothing.setReal", fmi2OK, L.SetReal(in->c, NULL, 0, NULL));
    ck_status("abi.nothing.setInteger", fmi2OK, L.SetInteger(in->c, NULL, 0, NULL));
    ck_status("abi.nothing.setBoolean", fmi2OK, L.SetBoolean(in->c, NULL, 0, NULL));
    ck_status("abi.nothing.setString", fmi2OK, L.SetString(in->c, NULL, 0, NULL));
    ck_status("abi.nothing.setRealInputDerivatives", fmi2OK, L.SetRealInputDerivatives(in->c, NULL, 0, NULL, NULL));
    ck_status("abi.nothing.getRealOutputDerivatives", fmi2OK, L.GetRealOutputDerivatives(in->c, NULL, 0, NULL, NULL));
}

static void abi_logging(struct inst *in)
{
    mark("abi.logging");
    ck_status("abi.logging.all", fmi2OK, L.SetDebugLogging(in->c, fmi2True, 0, NULL));
    ck_status("abi.logging.off", fmi2OK, L.SetDebugLogging(in->c, fmi2False, 0, NULL));
    for (int i = 0; i < g_ncategories; i++) {
        char *n = fmtdup("abi.logging.category %s", g_categories[i]);
        fmi2String s = g_categories[i];
        ck_status(n, fmi2OK, L.SetDebugLogging(in->c, fmi2True, 1, &s));
        ck_status(n, fmi2OK, L.SetDebugLogging(in->c, fmi2False, 1, &s));
        free(n);
    }
    if (g_ncategories) {
        const fmi2String *all = (const fmi2String *)g_categories;
        ck_status("abi.logging.categories", fmi2OK, L.SetDebugLogging(in->c, fmi2True, (size_t)g_ncategories, all));
    }
    L.SetDebugLogging(in->c, fmi2True, 0, NULL);
    fmi2String odd = "no%such%scategory%n";
    fmi2Status st = L.SetDebugLogging(in->c, fmi2True, 1, &odd);
    ck(st == fmi2Warning || refused(st), "abi.logging.unknown-category", "expected a warning or a refusal, came %s", stname(st));
    L.SetDebugLogging(in->c, fmi2True, 0, NULL);
    fmi2ValueReference none = 4294967295u;
    double v;
    long s0 = in->e->sentences;
    L.GetReal(in->c, &none, 1, &v);
    ck(in->e->sentences > s0, "abi.logging.on", "expected a sentence once logging is on, came none");
}

/* Texts with percent signs must come through the variadic logger whole. */
static void abi_percent(void)
{
    static const char *const name = "wheel %s 100%% %d%n";
    struct inst in;
    mark("abi.percent");
    if (ck(inst_open(&in, name), "abi.percent.name", "expected an instance, came NULL")) {
        fmi2ValueReference none = 4294967295u;
        double v;
        L.GetReal(in.c, &none, 1, &v);
        ck(in.e->sentences > 0, "abi.percent.log", "expected a sentence, came none");
        inst_close(&in);
    }
    struct env *e = env_new(name);
    fmi2Component c = instantiate(e, name, fmi2CoSimulation, "{%s%n%d-100%}", g_uri, fmi2True);
    ck(!c && e->sentences > 0, "abi.percent.guid", "expected NULL and a sentence, came %s and %ld", c ? "an instance" : "NULL", e->sentences);
    if (c) L.FreeInstance(c);
    c = instantiate(e, name, fmi2CoSimulation, g_guid, "file:///no%25s%25n/such%20folder", fmi2True);
    ck(!c, "abi.percent.uri", "expected NULL, came an instance");
    if (c) L.FreeInstance(c);
    env_free(e);
    if (!g_percents) note("no message with a percent sign was ever logged");
}

/* The callbacks and the strings belong to the caller and may be gone. */
static void abi_environment(void)
{
    struct inst in;
    mark("abi.environment");
    if (!inst_open(&in, "environment")) return;
    in.e->cb.logger = stale_logger;
    in.e->cb.allocateMemory = no_alloc;
    in.e->cb.componentEnvironment = NULL;
    fmi2ValueReference none = 4294967295u;
    double v;
    long s0 = in.e->messages;
    start(&in, &PLAIN);
    L.GetReal(in.c, &none, 1, &v);
    ck(in.e->messages > s0, "abi.environment", "expected the environment given at instantiation in the logger, came none");
    inst_close(&in);
}

static void mode_abi(int ncat, char **cat)
{
    g_ncategories = ncat;
    g_categories = cat;
    mark("abi.version");
    const char *s = L.GetTypesPlatform();
    ck(s && !strcmp(s, fmi2TypesPlatform), "abi.types-platform", "expected 'default', came '%s'", s ? s : "NULL");
    s = L.GetVersion();
    ck(s && !strcmp(s, "2.0"), "abi.version", "expected '2.0', came '%s'", s ? s : "NULL");

    abi_lifecycle();
    abi_values();

    struct inst in;
    mark("abi.instance");
    if (ck(inst_open(&in, "wheelset"), "abi.instance", "expected an instance, came NULL")) {
        double *a = xalloc(6 * g_nout, sizeof *a);
        ck_status("abi.instance.start", fmi2OK, start(&in, &PLAIN));
        ck_status("abi.instance.run", fmi2OK, run(&in, 5, 0.01, a));
        abi_model_exchange(&in);
        abi_status(&in);
        abi_nothing(&in);
        abi_logging(&in);
        ck_status("abi.instance.run-on", fmi2OK, run(&in, 5, 0.01, a));
        free(a);
        inst_close(&in);
    }
    abi_percent();
    abi_environment();

    mark("abi.model-exchange");
    struct env *e = env_new("exchange");
    fmi2Component c = instantiate(e, "exchange", fmi2ModelExchange, g_guid, g_uri, fmi2True);
    ck(!c && e->sentences > 0, "abi.model-exchange.instantiate", "expected NULL and a sentence, came %s and %ld",
       c ? "an instance" : "NULL", e->sentences);
    if (c) L.FreeInstance(c);
    env_free(e);

    mark("abi.visible");
    e = env_new("visible");
    c = L.Instantiate("visible", fmi2CoSimulation, g_guid, g_uri, &e->cb, fmi2True, fmi2False);
    ck(c != NULL, "abi.visible", "expected an instance, came NULL");
    if (c) L.FreeInstance(c);
    env_free(e);
}

/* ------------------------------------------------------------------ */
/* threads                                                             */

enum { THREAD_STEPS = 200 };

struct job {
    int index, in_main; /* in_main: instantiated by the main thread */
    char name[32];
    struct inst in;
    double *trace;
    fmi2Status st;
    pthread_barrier_t *gate;
};

static void *job_run(void *p)
{
    struct job *j = p;
    struct scen s = PLAIN;
    s.y0 = 1e-3 * (1.0 + 0.25 * (j->index % 16)) * (j->index & 1 ? -1 : 1);
    s.torque = 100.0 * (j->index % 20) - 700.0;
    if (j->gate) pthread_barrier_wait(j->gate);
    if (!j->in_main && !inst_open(&j->in, j->name)) { j->st = fmi2Fatal; return NULL; }
    j->st = j->in.c ? THEN(start(&j->in, &s), run(&j->in, THREAD_STEPS, 0.01, j->trace)) : fmi2Fatal;
    if (!j->in_main) inst_close(&j->in);
    return NULL;
}

static void mode_threads(int n)
{
    size_t rows = THREAD_STEPS + 1, size = rows * g_nout;
    struct job *j = xalloc((size_t)n, sizeof *j);
    double *serial = xalloc((size_t)n * size, sizeof *serial);
    double *parallel = xalloc((size_t)n * size, sizeof *parallel);
    pthread_t *th = xalloc((size_t)n, sizeof *th);
    for (int i = 0; i < n; i++) {
        j[i].index = i;
        snprintf(j[i].name, sizeof j[i].name, "wheelset %d", i);
        j[i].trace = serial + (size_t)i * size;
        mark("threads.serial");
        job_run(&j[i]);
        char *name = fmtdup("threads.serial %d", i);
        ck_status(name, fmi2OK, j[i].st);
        free(name);
    }
    for (int i = 1; i < n; i++)
        if (!memcmp(j[i].trace, j[i - 1].trace, size * sizeof(double)))
            ck(0, "threads.distinct", "expected different runs, came equal ones %d and %d", i - 1, i);

    mark("threads.parallel");
    pthread_barrier_t gate;
    pthread_barrier_init(&gate, NULL, (unsigned)n);
    for (int i = 0; i < n; i++) {
        memset(&j[i].in, 0, sizeof j[i].in);
        j[i].trace = parallel + (size_t)i * size;
        j[i].gate = &gate;
        j[i].in_main = i & 1;
        if (j[i].in_main) inst_open(&j[i].in, j[i].name);
        if (pthread_create(&th[i], NULL, job_run, &j[i])) { perror("pthread_create"); exit(1); }
    }
    for (int i = 0; i < n; i++) pthread_join(th[i], NULL);
    pthread_barrier_destroy(&gate);
    for (int i = 0; i < n; i++) {
        if (j[i].in_main) inst_close(&j[i].in);
        char *name = fmtdup("threads.parallel %d", i);
        ck_same(name, j[i].st, parallel + (size_t)i * size, serial + (size_t)i * size, rows);
        free(name);
    }
    free(j);
    free(serial);
    free(parallel);
    free(th);
}

/* ------------------------------------------------------------------ */
/* urls                                                                */

static void url_run(const char *name, const char *uri, const double *want)
{
    struct inst in;
    double *a = xalloc(11 * g_nout, sizeof *a);
    mark(name);
    if (ck(inst_open_at(&in, "located", uri), name, "expected an instance from %s, came NULL", uri)) {
        fmi2Status st = THEN(start(&in, &PLAIN), run(&in, 10, 0.01, a));
        if (want) ck_same(name, st, a, want, 11);
        inst_close(&in);
    }
    free(a);
}

static void url_all(const char *what, const char *path, const double *want)
{
    static const struct { const char *name, *prefix, *suffix; int lower; } forms[] = {
        { "file:/path", "file:", "", 0 },
        { "file:///path", "file://", "", 0 },
        { "file://localhost/path", "file://localhost", "", 0 },
        { "file:/path/", "file:", "/", 0 },
        { "file:///path/", "file://", "/", 0 },
        { "file://localhost/path/", "file://localhost", "/", 0 },
        { "lower-case hexadecimal", "file://", "", 1 },
    };
    for (size_t i = 0; i < sizeof forms / sizeof *forms; i++) {
        char *u = path_to_uri(forms[i].prefix, path, forms[i].lower);
        char *uri = fmtdup("%s%s", u, forms[i].suffix), *name = fmtdup("urls.%s.%s", what, forms[i].name);
        url_run(name, uri, want);
        free(u);
        free(uri);
        free(name);
    }
    /* A plain path means itself: percent signs in it stand for nothing else. */
    char *name = fmtdup("urls.%s.plain path", what);
    url_run(name, path, want);
    free(name);
}

static void url_refused(const char *name, const char *uri)
{
    struct inst in;
    mark(name);
    if (!ck(!inst_open_at(&in, "refused", uri), name, "expected NULL for %s, came an instance", uri)) inst_close(&in);
}

static void mode_urls(void)
{
    struct inst in;
    double *want = xalloc(11 * g_nout, sizeof *want);
    mark("urls.as-given");
    if (ck(inst_open(&in, "as given"), "urls.as-given", "expected an instance, came NULL")) {
        ck_status("urls.as-given", fmi2OK, THEN(start(&in, &PLAIN), run(&in, 10, 0.01, want)));
        inst_close(&in);
        char *path = uri_to_path(g_uri), *real = realpath(path, NULL);
        if (ck(real != NULL, "urls.path", "expected a folder behind the URI, came none at %s", path)) {
            url_all("original", real, want);
            static const char *const odd[][2] = {
                { "spaces", "two  spaces and one" },
                { "letters", "R\xc3\xa4" "der \xc3\xbc" "ber Stra\xc3\x9f" "e \xe8\xbd\xae" },
                { "signs", "100% #1 a%20b %n ?x&y=[z]+;'!" },
            };
            for (size_t i = 0; i < sizeof odd / sizeof *odd; i++) {
                char *tmp = temp_dir(), *to = fmtdup("%s/%s", tmp, odd[i][1]);
                if (ck(!copy_tree(real, to), "urls.copy", "expected a copy of the folder, came an error: %s", strerror(errno)))
                    url_all(odd[i][0], to, want);
                remove_tree(tmp);
                free(tmp);
                free(to);
            }
        }
        free(path);
        free(real);
        url_refused("urls.relative", "resources");
        url_refused("urls.other-scheme", "http://localhost/resources");
#ifndef _WIN32
        url_refused("urls.share", "file://server/share/resources");
#endif
    }
    free(want);
}

/* ------------------------------------------------------------------ */
/* bench                                                               */

static double cpu_now(void)
{
    struct timespec t;
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

static int by_value(const void *a, const void *b)
{
    double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

static void mode_bench(double h, double stop)
{
    enum { REPEATS = 5 };
    const fmi2ValueReference vr[3] = { g_key[K_Y], g_key[K_YAW], g_key[K_QL] };
    long n = lround(stop / h);
    for (int reads = 3; reads >= 0; reads -= 3) {
        double cpu[REPEATS], sum = 0;
        for (int r = 0; r < REPEATS; r++) {
            struct inst in;
            mark("bench");
            if (!ck(inst_open(&in, "bench"), "bench.instance", "expected an instance, came NULL")) return;
            fmi2Status st = start(&in, &UNTOUCHED);
            double v[3] = { 0 }, t0 = cpu_now();
            for (long i = 0; i < n && st == fmi2OK; i++) {
                st = step(&in, h);
                if (reads && st == fmi2OK) st = L.GetReal(in.c, vr, 3, v);
                sum += v[2];
            }
            cpu[r] = (cpu_now() - t0) / ((double)n * h);
            inst_close(&in);
            if (!ck_status(reads ? "bench.run.reading" : "bench.run", fmi2OK, st)) return;
        }
        qsort(cpu, REPEATS, sizeof *cpu, by_value);
        ck(isfinite(sum), "bench.finite", "expected finite outputs, came %g", sum);
        printf("bench step=%g stop=%g cpu_seconds_per_simulated_second=%.6g steps=%ld reads=%d\n", h, stop,
               cpu[REPEATS / 2], n, reads);
    }
}

/* ------------------------------------------------------------------ */
/* csv                                                                 */

static void csv_row(FILE *f, double t, const double *v)
{
    fprintf(f, "%a", t);
    for (size_t i = 0; i < g_nout; i++) fprintf(f, ",%a", v[i]);
    fputc('\n', f);
}

/* NAME=VALUE before initialization; 0 on success. */
static int csv_set(struct inst *in, const char *arg)
{
    const char *eq = strrchr(arg, '=');
    char *name = eq ? fmtdup("%.*s", (int)(eq - arg), arg) : NULL, *end = NULL;
    const struct var *v = name ? find_var(name) : NULL;
    free(name);
    if (!v) return -1;
    double x = strtod(eq + 1, &end);
    fmi2Integer i = (fmi2Integer)x;
    fmi2Boolean b = x != 0;
    if (v->type == T_STRING) return L.SetString(in->c, &v->vr, 1, (const fmi2String[]){ eq + 1 }) != fmi2OK;
    if (end == eq + 1 || *end) return -1;
    return (v->type == T_REAL ? L.SetReal(in->c, &v->vr, 1, &x)
          : v->type == T_INTEGER ? L.SetInteger(in->c, &v->vr, 1, &i)
          : L.SetBoolean(in->c, &v->vr, 1, &b)) != fmi2OK;
}

static int mode_csv(const char *steps, const char *out, int nset, char **set)
{
    FILE *in_f = fopen(steps, "r");
    if (!in_f) { perror(steps); return 2; }
    FILE *f = fopen(out, "w");
    if (!f) { perror(out); fclose(in_f); return 2; }
    struct inst in;
    double *v = xalloc(g_nout, sizeof *v), t, h;
    size_t n = 0;
    mark("csv");
    if (ck(inst_open(&in, "csv"), "csv.instance", "expected an instance, came NULL")) {
        int got = fscanf(in_f, "%la %la", &t, &h), setting = 0;
        struct scen s = UNTOUCHED;
        s.start = got == 2 ? t : 0;
        for (int i = 0; i < nset; i++)
            setting |= !ck(!csv_set(&in, set[i]), "csv.set", "expected %s to be settable, came a refusal", set[i]);
        fmi2Status st = THEN(start(&in, &s), outputs(&in, v));
        if (!setting && ck_status("csv.start", fmi2OK, st)) {
            fputs("time", f);
            for (size_t i = 0; i < g_nout; i++) {
                if (strpbrk(g_out_name[i], ",\"")) {
                    fputs(",\"", f);
                    for (const char *p = g_out_name[i]; *p; p++) {
                        if (*p == '"') fputc('"', f);
                        fputc(*p, f);
                    }
                    fputc('"', f);
                } else {
                    fprintf(f, ",%s", g_out_name[i]);
                }
            }
            fputc('\n', f);
            csv_row(f, s.start, v);
            while (got == 2) {
                st = THEN(L.DoStep(in.c, t, h, fmi2True), outputs(&in, v));
                if (st != fmi2OK) break;
                csv_row(f, t + h, v);
                n++;
                got = fscanf(in_f, "%la %la", &t, &h);
            }
            ck(st == fmi2OK, "csv.steps", "expected fmi2OK, came %s at step %zu", stname(st), n);
            ck(got == EOF, "csv.file", "expected pairs 'time step' in %s, came others after %zu steps", steps, n);
        }
        inst_close(&in);
    }
    free(v);
    fclose(in_f);
    ck(!fclose(f), "csv.written", "expected %s written, came an error", out);
    return 0;
}

/* ------------------------------------------------------------------ */
/* bad                                                                 */

enum phase { PH_INSTANTIATED, PH_SETUP, PH_INITIALIZATION, PH_STEPPING };

/* Instance a takes the bad calls, b never does; both run in step. */
struct pair {
    struct inst a, b;
    enum phase phase;
    struct scen s;
    double *va, *vb;
};

static int pair_open(struct pair *p, enum phase phase, const struct scen *s)
{
    p->s = *s;
    p->phase = phase;
    p->va = xalloc(g_nout, sizeof *p->va);
    p->vb = xalloc(g_nout, sizeof *p->vb);
    memset(&p->b, 0, sizeof p->b);
    if (!inst_open(&p->a, "disturbed") || !inst_open(&p->b, "undisturbed"))
        return ck(0, "bad.instance", "expected an instance, came NULL");
    fmi2Status st = fmi2OK;
    struct inst *two[2] = { &p->a, &p->b };
    for (int i = 0; i < 2; i++) {
        st = THEN(st, set_parameters(two[i], s));
        if (phase >= PH_SETUP) st = THEN(st, setup(two[i], s));
        if (phase >= PH_INITIALIZATION) {
            st = THEN(st, L.EnterInitializationMode(two[i]->c));
            st = THEN(st, set_inputs(two[i], s));
        }
        if (phase >= PH_STEPPING) {
            st = THEN(st, L.ExitInitializationMode(two[i]->c));
            st = THEN(st, step(two[i], 0.01));
        }
    }
    if (st != fmi2OK) ck(0, "bad.start", "expected fmi2OK, came %s", stname(st));
    return st == fmi2OK;
}

static void pair_close(struct pair *p)
{
    inst_close(&p->a);
    inst_close(&p->b);
    free(p->va);
    free(p->vb);
    p->va = p->vb = NULL;
}

/* Equal outputs now; NULL or the text of the difference. */
static char *pair_compare(struct pair *p)
{
    fmi2Status st = outputs(&p->a, p->va), st2 = outputs(&p->b, p->vb);
    if (st != fmi2OK || st2 != fmi2OK) return fmtdup("outputs: expected fmi2OK, came %s", stname(worse(st, st2)));
    return same(p->va, p->vb, 1) ? NULL : difference(p->va, p->vb, 1);
}

/* One step of both, compared before and after. */
static char *pair_step(struct pair *p, double h)
{
    char *d = pair_compare(p);
    if (d) return d;
    fmi2Status st = step(&p->a, h), st2 = step(&p->b, h);
    if (st != fmi2OK || st2 != fmi2OK) return fmtdup("next step: expected fmi2OK, came %s", stname(worse(st, st2)));
    return pair_compare(p);
}

/* From any phase through the start to some steps. */
static char *pair_finish(struct pair *p)
{
    struct inst *two[2] = { &p->a, &p->b };
    for (int i = 0; i < 2; i++) {
        fmi2Status st = fmi2OK;
        if (p->phase < PH_SETUP) st = THEN(st, setup(two[i], &p->s));
        if (p->phase < PH_INITIALIZATION) {
            st = THEN(st, L.EnterInitializationMode(two[i]->c));
            st = THEN(st, set_inputs(two[i], &p->s));
        }
        if (p->phase < PH_STEPPING) st = THEN(st, L.ExitInitializationMode(two[i]->c));
        if (st != fmi2OK) return fmtdup("going on: expected fmi2OK, came %s", stname(st));
    }
    p->phase = PH_STEPPING;
    char *d = NULL;
    for (int i = 0; i < 5 && !d; i++) d = pair_step(p, 0.01);
    return d;
}

static void judge(const char *name, fmi2Status st, long sentences, char *diff)
{
    if (!refused(st)) ck(0, name, "expected fmi2Error or fmi2Discard, came %s", stname(st));
    else if (!sentences) ck(0, name, "expected a sentence in the log, came none");
    else if (diff) ck(0, name, "expected the instance as it was, came %s", diff);
    else ck(1, name, " ");
    free(diff);
}

/* A pair in step mode is renewed when spoilt or at its end. */
static void judge_step(struct pair *p, const char *name, fmi2Status st, long sentences)
{
    char *d = pair_step(p, 0.005);
    int renew = d || p->a.t > 1.4;
    judge(name, st, sentences, d);
    if (renew) {
        struct scen s = p->s;
        pair_close(p);
        if (!pair_open(p, PH_STEPPING, &s)) exit(1);
    }
}

/* A bad call in step mode. */
#define BAD(nm, expr)                                        \
    do {                                                     \
        mark("bad." nm);                                     \
        long s0_ = P.a.e->sentences;                         \
        fmi2Status st_ = (expr);                             \
        judge_step(&P, "bad." nm, st_, P.a.e->sentences - s0_); \
    } while (0)

/* A bad call earlier in the life cycle, with a pair of its own. */
#define BAD_AT(ph, nm, expr)                                 \
    do {                                                     \
        mark("bad." nm);                                     \
        struct pair P;                                       \
        if (pair_open(&P, ph, &PLAIN)) {                     \
            long s0_ = P.a.e->sentences;                     \
            fmi2Status st_ = (expr);                         \
            s0_ = P.a.e->sentences - s0_;                    \
            judge("bad." nm, st_, s0_, pair_finish(&P));     \
        }                                                    \
        pair_close(&P);                                      \
    } while (0)

/* A call that must not crash, refused or not, and leave no trace. */
#define TOLERATED(nm, expr)                                  \
    do {                                                     \
        mark("bad." nm);                                     \
        fmi2Status st_ = (expr);                             \
        char *d_ = pair_step(&P, 0.005);                     \
        ck(!d_ && (st_ == fmi2OK || refused(st_)), "bad." nm, "expected an unharmed instance, came %s: %s", \
           stname(st_), d_ ? d_ : "");                       \
        free(d_);                                            \
    } while (0)

static fmi2Status set_real(struct inst *in, fmi2ValueReference vr, double v)
{
    return L.SetReal(in->c, &vr, 1, &v);
}

static fmi2Status set_input_derivative(struct inst *in, fmi2ValueReference vr, fmi2Integer order, double v)
{
    return L.SetRealInputDerivatives(in->c, &vr, 1, &order, &v);
}

static fmi2Status get_output_derivative(struct inst *in, fmi2ValueReference vr, fmi2Integer order)
{
    double v = 0;
    return L.GetRealOutputDerivatives(in->c, &vr, 1, &order, &v);
}

static fmi2ValueReference unknown_vr(void)
{
    fmi2ValueReference vr = 0;
    while (vr_used(vr, -1)) vr++;
    return vr;
}

/* A variable of one type whose reference is none of another type. */
static const struct var *only_of(enum vtype have, enum vtype other)
{
    for (size_t i = 0; i < g_nvars; i++)
        if (g_vars[i].type == have && !vr_used(g_vars[i].vr, other)) return &g_vars[i];
    return NULL;
}

static void bad_variables(void)
{
    struct pair P;
    if (!pair_open(&P, PH_STEPPING, &PLAIN)) { pair_close(&P); return; }
    fmi2ValueReference none[2] = { unknown_vr(), 4294967295u };
    double r[8] = { 1, 2, 3, 4 };
    fmi2Integer i[8] = { 1 };
    fmi2Boolean b[8] = { 0 };
    fmi2String s[8] = { "text" };

    BAD("unknown.getReal", L.GetReal(P.a.c, &none[0], 1, r));
    BAD("unknown.getReal-largest", L.GetReal(P.a.c, &none[1], 1, r));
    BAD("unknown.getInteger", L.GetInteger(P.a.c, &none[0], 1, i));
    BAD("unknown.getBoolean", L.GetBoolean(P.a.c, &none[0], 1, b));
    BAD("unknown.getString", L.GetString(P.a.c, &none[0], 1, s));
    BAD("unknown.setReal", L.SetReal(P.a.c, &none[0], 1, r));
    BAD("unknown.setReal-largest", L.SetReal(P.a.c, &none[1], 1, r));
    BAD("unknown.setInteger", L.SetInteger(P.a.c, &none[0], 1, i));
    BAD("unknown.setBoolean", L.SetBoolean(P.a.c, &none[0], 1, b));
    s[0] = "text";
    BAD("unknown.setString", L.SetString(P.a.c, &none[0], 1, s));

    /* a refused set changes nothing, its good part neither */
    fmi2ValueReference mixed[3] = { g_key[K_TORQUE], g_key[K_LATERAL], none[0] };
    double big[3] = { 9000, 9000, 9000 };
    BAD("unknown.setReal-mixed", L.SetReal(P.a.c, mixed, 3, big));
    mixed[2] = g_key[K_Y];
    BAD("output.setReal-mixed", L.SetReal(P.a.c, mixed, 3, big));
    mixed[2] = g_key[K_VERTICAL];
    big[2] = NAN;
    BAD("nan.setReal-mixed", L.SetReal(P.a.c, mixed, 3, big));

    for (int have = 0; have < T_COUNT; have++)
        for (int other = 0; other < T_COUNT; other++) {
            const struct var *v = have == other ? NULL : only_of((enum vtype)have, (enum vtype)other);
            if (!v) continue;
            for (int set = 0; set < 2; set++) {
                char *name = fmtdup("bad.wrong-type.%s%s-of-%s", set ? "set" : "get", TYPE_NAMES[other], TYPE_NAMES[have]);
                mark(name);
                long s0 = P.a.e->sentences;
                r[0] = 1; i[0] = 1; b[0] = 0; s[0] = "text";
                const fmi2ValueReference *vr = &v->vr;
                fmi2Component c = P.a.c;
                fmi2Status st =
                    other == T_REAL ? (set ? L.SetReal(c, vr, 1, r) : L.GetReal(c, vr, 1, r))
                  : other == T_INTEGER ? (set ? L.SetInteger(c, vr, 1, i) : L.GetInteger(c, vr, 1, i))
                  : other == T_BOOLEAN ? (set ? L.SetBoolean(c, vr, 1, b) : L.GetBoolean(c, vr, 1, b))
                  : (set ? L.SetString(c, vr, 1, s) : L.GetString(c, vr, 1, s));
                judge_step(&P, name, st, P.a.e->sentences - s0);
                mark("bad.variables");
                free(name);
            }
        }

    BAD("output.setReal", set_real(&P.a, g_key[K_Y], 0.001));
    BAD("output.setReal-force", set_real(&P.a, g_key[K_QL], 1e5));
    BAD("parameter.setReal-mass", set_real(&P.a, g_key[K_MASS], 1234));
    BAD("parameter.setReal-initial", set_real(&P.a, g_key[K_IY], 0.002));
    fmi2Boolean no = fmi2False;
    BAD("parameter.setBoolean", L.SetBoolean(P.a.c, &g_key[K_EQUILIBRIUM], 1, &no));
    for (size_t k = 0; k < g_nvars; k++)
        if (g_vars[k].type == T_REAL && strcmp(g_vars[k].causality, "input")) {
            char *name = fmtdup("bad.set.%s %s", g_vars[k].causality, g_vars[k].name);
            mark(name);
            long s0 = P.a.e->sentences;
            /* A tunable parameter may be set, but not to this. */
            fmi2Status st = set_real(&P.a, g_vars[k].vr, strcmp(g_vars[k].causality, "tunable") ? 0.5 : NAN);
            s0 = P.a.e->sentences - s0;
            char *d = pair_compare(&P);
            if (!refused(st) || !s0 || d) judge(name, st, s0, d);
            else g_ok++;
            mark("bad.variables");
            free(name);
        }
    BAD("set.every-other", L.SetReal(P.a.c, g_out_vr, 1, r));

    static const struct { const char *name; enum key k; } in[] = {
        { "driveTorque", K_TORQUE }, { "lateralForceInput", K_LATERAL }, { "verticalForceInput", K_VERTICAL },
        { "left.frictionFactor", K_MU_L }, { "right.frictionFactor", K_MU_R } };
    static const double odd[] = { NAN, INFINITY, -INFINITY };
    static const char *const oddname[] = { "nan", "inf", "-inf" };
    for (size_t k = 0; k < sizeof in / sizeof *in; k++)
        for (int o = 0; o < 3; o++) {
            char *name = fmtdup("bad.input.%s-%s", in[k].name, oddname[o]);
            mark(name);
            long s0 = P.a.e->sentences;
            fmi2Status st = set_real(&P.a, g_key[in[k].k], odd[o]);
            judge_step(&P, name, st, P.a.e->sentences - s0);
            mark("bad.variables");
            free(name);
        }

    BAD("input-derivative.order-0", set_input_derivative(&P.a, g_key[K_TORQUE], 0, 1.0));
    BAD("input-derivative.order-3", set_input_derivative(&P.a, g_key[K_TORQUE], 3, 1.0));
    BAD("input-derivative.order-negative", set_input_derivative(&P.a, g_key[K_TORQUE], -1, 1.0));
    BAD("input-derivative.nan", set_input_derivative(&P.a, g_key[K_TORQUE], 1, NAN));
    BAD("input-derivative.inf", set_input_derivative(&P.a, g_key[K_TORQUE], 1, INFINITY));
    BAD("input-derivative.output", set_input_derivative(&P.a, g_key[K_Y], 1, 1.0));
    BAD("input-derivative.parameter", set_input_derivative(&P.a, g_key[K_MASS], 1, 1.0));
    BAD("input-derivative.unknown", set_input_derivative(&P.a, none[0], 1, 1.0));
    fmi2ValueReference two[2] = { g_key[K_TORQUE], g_key[K_LATERAL] };
    fmi2Integer orders[2] = { 1, 3 };
    double slopes[2] = { 1e5, 1e5 };
    BAD("input-derivative.mixed", L.SetRealInputDerivatives(P.a.c, two, 2, orders, slopes));
    BAD("output-derivative.order-3", get_output_derivative(&P.a, g_key[K_Y], 3));
    BAD("output-derivative.order-0", get_output_derivative(&P.a, g_key[K_Y], 0));
    BAD("output-derivative.order-negative", get_output_derivative(&P.a, g_key[K_Y], -1));
    BAD("output-derivative.unknown", get_output_derivative(&P.a, none[0], 1));
    BAD("output-derivative.parameter", get_output_derivative(&P.a, g_key[K_MASS], 1));
    pair_close(&P);

    /* what must be accepted */
    if (!pair_open(&P, PH_STEPPING, &PLAIN)) { pair_close(&P); return; }
    mark("good.derivatives");
    ck_status("good.input-derivative.order-1", fmi2OK, set_input_derivative(&P.a, g_key[K_TORQUE], 1, 0.0));
    ck_status("good.input-derivative.order-2", fmi2OK, set_input_derivative(&P.a, g_key[K_TORQUE], 2, 0.0));
    char *d = pair_step(&P, 0.01);
    ck(!d, "good.input-derivative.zero", "expected a constant input, came %s", d ? d : "");
    free(d);
    ck_status("good.output-derivative.order-1", fmi2OK, get_output_derivative(&P.a, g_key[K_Y], 1));
    ck_status("good.output-derivative.order-2", fmi2OK, get_output_derivative(&P.a, g_key[K_Y], 2));
    size_t bad = 0;
    const char *first = "";
    for (size_t k = 0; k < g_nout; k++) {
        fmi2Integer one = 1;
        double v = NAN;
        fmi2Status st = L.GetRealOutputDerivatives(P.a.c, &g_out_vr[k], 1, &one, &v);
        if (st != fmi2OK || !isfinite(v))
            if (!bad++) first = g_out_name[k];
    }
    ck(!bad, "good.output-derivative.all", "expected finite derivatives of all outputs, came %zu others, first %s", bad, first);
    fmi2Integer one = 1;
    double v = NAN;
    L.GetRealOutputDerivatives(P.a.c, &g_key[K_DISTANCE], 1, &one, &v);
    ck(fabs(v - 40) < 4, "good.output-derivative.distance", "expected about 40 m/s, came %g", v);
    ck_status("good.input-derivative.slope", fmi2OK, set_input_derivative(&P.a, g_key[K_TORQUE], 1, 1e4));
    step(&P.a, 0.01);
    step(&P.b, 0.01);
    d = pair_compare(&P);
    ck(d != NULL, "good.input-derivative.effect", "expected other outputs under a rising torque, came equal ones");
    free(d);
    pair_close(&P);
}

static void bad_steps(void)
{
    struct pair P;
    if (!pair_open(&P, PH_STEPPING, &PLAIN)) { pair_close(&P); return; }
    BAD("step.negative", L.DoStep(P.a.c, P.a.t, -0.01, fmi2True));
    BAD("step.zero", L.DoStep(P.a.c, P.a.t, 0.0, fmi2True));
    BAD("step.minus-zero", L.DoStep(P.a.c, P.a.t, -0.0, fmi2True));
    BAD("step.nan", L.DoStep(P.a.c, P.a.t, NAN, fmi2True));
    BAD("step.inf", L.DoStep(P.a.c, P.a.t, INFINITY, fmi2True));
    BAD("step.-inf", L.DoStep(P.a.c, P.a.t, -INFINITY, fmi2True));
    BAD("step.time-nan", L.DoStep(P.a.c, NAN, 0.01, fmi2True));
    BAD("step.time-inf", L.DoStep(P.a.c, INFINITY, 0.01, fmi2True));
    BAD("step.time-later", L.DoStep(P.a.c, P.a.t + 0.01, 0.01, fmi2True));
    BAD("step.time-earlier", L.DoStep(P.a.c, P.a.t - 0.01, 0.01, fmi2True));
    BAD("step.time-zero", L.DoStep(P.a.c, 0.0, 0.01, fmi2True));
    BAD("order.enterInit", L.EnterInitializationMode(P.a.c));
    BAD("order.exitInit", L.ExitInitializationMode(P.a.c));
    BAD("order.setupExperiment", setup(&(struct inst){ .c = P.a.c }, &PLAIN));
    pair_close(&P);

    /* the tolerance of the communication point, at t = 1 */
    for (int k = 0; k < 4; k++) {
        static const char *const names[] = { "bad.step.time-1e-8-later", "bad.step.time-1e-8-earlier",
                                             "good.step.time-5e-10-later", "good.step.time-5e-10-earlier" };
        static const double off[] = { 1e-8, -1e-8, 5e-10, -5e-10 };
        mark(names[k]);
        if (!pair_open(&P, PH_STEPPING, &PLAIN)) { pair_close(&P); return; }
        for (int i = 1; i < 100; i++) step(&P.a, 0.01), step(&P.b, 0.01);
        long s0 = P.a.e->sentences;
        fmi2Status st = L.DoStep(P.a.c, P.a.t * (1 + off[k]), 0.01, fmi2True);
        s0 = P.a.e->sentences - s0;
        if (k < 2) {
            judge(names[k], st, s0, pair_step(&P, 0.01));
        } else {
            ck_status(names[k], fmi2OK, st);
            P.a.t += 0.01;
            ck_status(names[k], fmi2OK, step(&P.a, 0.01));
        }
        pair_close(&P);
    }

    /* the stop time */
    struct scen s = PLAIN;
    s.has_stop = 1;
    s.stop = 0.1;
    mark("bad.stop");
    if (!pair_open(&P, PH_STEPPING, &s)) { pair_close(&P); return; }
    BAD("stop.far-beyond", L.DoStep(P.a.c, P.a.t, 1.0, fmi2True));
    BAD("stop.just-beyond", L.DoStep(P.a.c, P.a.t, 0.0851, fmi2True));
    char *d = NULL;
    while (!d && P.a.t < 0.0999) d = pair_step(&P, 0.005);
    ck(!d, "good.stop.reach", "expected steps up to the stop time, came %s", d ? d : "");
    free(d);
    long s0 = P.a.e->sentences;
    fmi2Status st = L.DoStep(P.a.c, P.a.t, 0.005, fmi2True);
    judge("bad.stop.beyond", st, P.a.e->sentences - s0, pair_compare(&P));
    ck_status("good.stop.terminate", fmi2OK, L.Terminate(P.a.c));
    pair_close(&P);

    /* sums of steps end beside the stop time */
    struct inst in;
    mark("good.stop.sum");
    if (inst_open(&in, "sum")) {
        s.stop = 1.0;
        st = start(&in, &s);
        for (int i = 0; i < 100; i++) st = THEN(st, step(&in, 0.01));
        ck_status("good.stop.sum", fmi2OK, st);
        inst_close(&in);
    }

    /* after terminate */
    if (!pair_open(&P, PH_STEPPING, &PLAIN)) { pair_close(&P); return; }
    mark("bad.terminated");
    double *v = xalloc(g_nout, sizeof *v);
    outputs(&P.b, v);
    ck_status("bad.terminated.terminate", fmi2OK, THEN(L.Terminate(P.a.c), L.Terminate(P.b.c)));
    s0 = P.a.e->sentences;
    st = L.DoStep(P.a.c, P.a.t, 0.01, fmi2True);
    judge("bad.terminated.doStep", st, P.a.e->sentences - s0, pair_compare(&P));
    ck_same("bad.terminated.outputs", outputs(&P.a, P.va), P.va, v, 1);
    st = THEN(L.Reset(P.a.c), L.Reset(P.b.c));
    st = THEN(st, THEN(start(&P.a, &PLAIN), start(&P.b, &PLAIN)));
    ck_status("bad.terminated.restart", fmi2OK, st);
    d = pair_finish(&P);
    ck(!d, "bad.terminated.run", "expected equal runs after reset, came %s", d ? d : "");
    free(d);
    free(v);
    pair_close(&P);
}

static fmi2Status experiment(struct inst *in, double t0, int has_stop, double t1)
{
    return L.SetupExperiment(in->c, fmi2False, 0.0, t0, has_stop, t1);
}

static void bad_order(void)
{
    BAD_AT(PH_INSTANTIATED, "early.doStep", L.DoStep(P.a.c, 0.0, 0.01, fmi2True));
    BAD_AT(PH_INSTANTIATED, "early.exitInit", L.ExitInitializationMode(P.a.c));
    BAD_AT(PH_SETUP, "early.doStep-after-setup", L.DoStep(P.a.c, 0.0, 0.01, fmi2True));
    BAD_AT(PH_SETUP, "early.exitInit-after-setup", L.ExitInitializationMode(P.a.c));
    BAD_AT(PH_INITIALIZATION, "early.doStep-in-init", L.DoStep(P.a.c, 0.0, 0.01, fmi2True));
    BAD_AT(PH_INITIALIZATION, "init.enter-twice", L.EnterInitializationMode(P.a.c));
    BAD_AT(PH_INITIALIZATION, "init.setupExperiment", experiment(&P.a, 0.0, 0, 0.0));
    BAD_AT(PH_INSTANTIATED, "experiment.stop-before-start", experiment(&P.a, 1.0, 1, 0.5));
    BAD_AT(PH_INSTANTIATED, "experiment.start-nan", experiment(&P.a, NAN, 0, 0.0));
    BAD_AT(PH_INSTANTIATED, "experiment.start-inf", experiment(&P.a, INFINITY, 0, 0.0));
    BAD_AT(PH_INSTANTIATED, "experiment.stop-nan", experiment(&P.a, 0.0, 1, NAN));
    BAD_AT(PH_INSTANTIATED, "parameter.nan", set_real(&P.a, g_key[K_IY], NAN));
    BAD_AT(PH_INSTANTIATED, "parameter.inf", set_real(&P.a, g_key[K_IY], INFINITY));
    BAD_AT(PH_INSTANTIATED, "parameter.mass-nan", set_real(&P.a, g_key[K_MASS], NAN));
    BAD_AT(PH_INITIALIZATION, "parameter.nan-in-init", set_real(&P.a, g_key[K_IY], NAN));
    BAD_AT(PH_INITIALIZATION, "input.nan-in-init", set_real(&P.a, g_key[K_TORQUE], NAN));
    BAD_AT(PH_INSTANTIATED, "output.set-early", set_real(&P.a, g_key[K_Y], 0.001));
    BAD_AT(PH_INITIALIZATION, "output.set-in-init", set_real(&P.a, g_key[K_Y], 0.001));
    BAD_AT(PH_INSTANTIATED, "unknown.set-early", set_real(&P.a, unknown_vr(), 0.001));
    BAD_AT(PH_INSTANTIATED, "model-exchange.early", L.SetTime(P.a.c, 1.0));
}

static void bad_null_pointers(void)
{
    struct pair P;
    if (!pair_open(&P, PH_STEPPING, &PLAIN)) { pair_close(&P); return; }
    const fmi2ValueReference *vr = &g_key[K_TORQUE], *by = &g_key[K_EQUILIBRIUM], *out = &g_key[K_Y];
    double r = 1;
    fmi2Integer i = 1;
    fmi2Boolean b = 0;
    fmi2String s = "text", nothing = NULL;
    BAD("null.getReal-vr", L.GetReal(P.a.c, NULL, 1, &r));
    BAD("null.getReal-value", L.GetReal(P.a.c, vr, 1, NULL));
    BAD("null.getInteger-vr", L.GetInteger(P.a.c, NULL, 1, &i));
    BAD("null.getInteger-value", L.GetInteger(P.a.c, vr, 1, NULL));
    BAD("null.getBoolean-vr", L.GetBoolean(P.a.c, NULL, 1, &b));
    BAD("null.getBoolean-value", L.GetBoolean(P.a.c, by, 1, NULL));
    BAD("null.getString-vr", L.GetString(P.a.c, NULL, 1, &s));
    BAD("null.getString-value", L.GetString(P.a.c, vr, 1, NULL));
    r = 1; i = 1; b = 0; s = "text";
    BAD("null.setReal-vr", L.SetReal(P.a.c, NULL, 1, &r));
    BAD("null.setReal-value", L.SetReal(P.a.c, vr, 1, NULL));
    BAD("null.setInteger-vr", L.SetInteger(P.a.c, NULL, 1, &i));
    BAD("null.setInteger-value", L.SetInteger(P.a.c, vr, 1, NULL));
    BAD("null.setBoolean-vr", L.SetBoolean(P.a.c, NULL, 1, &b));
    BAD("null.setBoolean-value", L.SetBoolean(P.a.c, by, 1, NULL));
    BAD("null.setString-vr", L.SetString(P.a.c, NULL, 1, &s));
    BAD("null.setString-value", L.SetString(P.a.c, vr, 1, NULL));
    BAD("null.setString-text", L.SetString(P.a.c, vr, 1, &nothing));
    for (size_t k = 0; k < g_nvars; k++)
        if (g_vars[k].type == T_STRING) {
            vr = &g_vars[k].vr;
            BAD("null.getString-known", L.GetString(P.a.c, vr, 1, NULL));
            BAD("null.setString-known", L.SetString(P.a.c, vr, 1, &nothing));
            vr = &g_key[K_TORQUE];
            break;
        }
    fmi2Integer one = 1;
    double zero = 0;
    BAD("null.inputDerivatives-vr", L.SetRealInputDerivatives(P.a.c, NULL, 1, &one, &zero));
    BAD("null.inputDerivatives-order", L.SetRealInputDerivatives(P.a.c, vr, 1, NULL, &zero));
    BAD("null.inputDerivatives-value", L.SetRealInputDerivatives(P.a.c, vr, 1, &one, NULL));
    BAD("null.outputDerivatives-vr", L.GetRealOutputDerivatives(P.a.c, NULL, 1, &one, &zero));
    BAD("null.outputDerivatives-order", L.GetRealOutputDerivatives(P.a.c, out, 1, NULL, &zero));
    BAD("null.outputDerivatives-value", L.GetRealOutputDerivatives(P.a.c, out, 1, &one, NULL));
    double dv = 1, du = 0;
    TOLERATED("directional", L.GetDirectionalDerivative(P.a.c, out, 1, vr, 1, &dv, &du));
    BAD("null.directional-unknown", L.GetDirectionalDerivative(P.a.c, NULL, 1, vr, 1, &dv, &du));
    BAD("null.directional-known", L.GetDirectionalDerivative(P.a.c, out, 1, NULL, 1, &dv, &du));
    BAD("null.directional-dvKnown", L.GetDirectionalDerivative(P.a.c, out, 1, vr, 1, NULL, &du));
    BAD("null.directional-dvUnknown", L.GetDirectionalDerivative(P.a.c, out, 1, vr, 1, &dv, NULL));
    BAD("null.getStatus", L.GetStatus(P.a.c, fmi2DoStepStatus, NULL));
    BAD("null.getRealStatus", L.GetRealStatus(P.a.c, fmi2LastSuccessfulTime, NULL));
    BAD("null.getIntegerStatus", L.GetIntegerStatus(P.a.c, fmi2DoStepStatus, NULL));
    BAD("null.getBooleanStatus", L.GetBooleanStatus(P.a.c, fmi2Terminated, NULL));
    BAD("null.getStringStatus", L.GetStringStatus(P.a.c, fmi2PendingStatus, NULL));
    BAD("null.setDebugLogging", L.SetDebugLogging(P.a.c, fmi2True, 1, NULL));
    BAD("null.setDebugLogging-category", L.SetDebugLogging(P.a.c, fmi2True, 1, &nothing));
    BAD("null.newDiscreteStates", L.NewDiscreteStates(P.a.c, NULL));
    BAD("null.completedIntegratorStep", L.CompletedIntegratorStep(P.a.c, fmi2True, NULL, NULL));
    BAD("null.setContinuousStates", L.SetContinuousStates(P.a.c, NULL, 1));
    BAD("null.getDerivatives", L.GetDerivatives(P.a.c, NULL, 1));
    BAD("null.getEventIndicators", L.GetEventIndicators(P.a.c, NULL, 1));
    BAD("null.getContinuousStates", L.GetContinuousStates(P.a.c, NULL, 1));
    BAD("null.getNominals", L.GetNominalsOfContinuousStates(P.a.c, NULL, 1));

    fmi2FMUstate state = NULL, made = NULL;
    size_t n = 0;
    BAD("null.getFMUstate", L.GetFMUstate(P.a.c, NULL));
    BAD("null.setFMUstate", L.SetFMUstate(P.a.c, NULL));
    TOLERATED("null.freeFMUstate", L.FreeFMUstate(P.a.c, NULL));
    fmi2FMUstate empty = NULL;
    mark("bad.null.freeFMUstate-of-null");
    ck_status("good.freeFMUstate-of-null", fmi2OK, L.FreeFMUstate(P.a.c, &empty));
    BAD("null.serializedSize-state", L.SerializedFMUstateSize(P.a.c, NULL, &n));
    if (ck_status("bad.null.state", fmi2OK, L.GetFMUstate(P.a.c, &state)) && state) {
        BAD("null.serializedSize-size", L.SerializedFMUstateSize(P.a.c, state, NULL));
        ck_status("bad.null.size", fmi2OK, L.SerializedFMUstateSize(P.a.c, state, &n));
        char *blob = xalloc(n, 1);
        BAD("null.serialize-state", L.SerializeFMUstate(P.a.c, NULL, blob, n));
        BAD("null.serialize-buffer", L.SerializeFMUstate(P.a.c, state, NULL, n));
        ck_status("bad.null.serialize", fmi2OK, L.SerializeFMUstate(P.a.c, state, blob, n));
        BAD("null.deserialize-buffer", L.DeSerializeFMUstate(P.a.c, NULL, n, &made));
        BAD("null.deserialize-state", L.DeSerializeFMUstate(P.a.c, blob, n, NULL));
        ck(!made, "bad.null.deserialize-made", "expected no state, came one");
        free(blob);
        L.FreeFMUstate(P.a.c, &state);
    }
    pair_close(&P);
}

/* Every function of an instance with none. */
static void bad_null_component(void)
{
    fmi2ValueReference vr = g_key[K_TORQUE];
    double r = 0;
    fmi2Integer i = 1;
    fmi2Boolean b = 0, b2 = 0;
    fmi2String s = "text";
    fmi2FMUstate state = NULL;
    fmi2EventInfo info;
    fmi2Status st = fmi2OK;
    size_t n = 0;
    char blob[64] = { 0 };
    char thing[64] = { 0 };
    fmi2FMUstate odd = thing;
#define NC(nm, ...) \
    mark("bad.no-component." #nm); \
    ck_status("bad.no-component." #nm, fmi2Error, L.nm(NULL, __VA_ARGS__));
#define NC0(nm) \
    mark("bad.no-component." #nm); \
    ck_status("bad.no-component." #nm, fmi2Error, L.nm(NULL));
    NC(SetDebugLogging, fmi2True, 0, NULL)
    NC(SetupExperiment, fmi2False, 0, 0, fmi2False, 0)
    NC0(EnterInitializationMode)
    NC0(ExitInitializationMode)
    NC0(Terminate)
    NC0(Reset)
    NC(GetReal, &vr, 1, &r)
    NC(GetInteger, &vr, 1, &i)
    NC(GetBoolean, &vr, 1, &b)
    NC(GetString, &vr, 1, &s)
    NC(SetReal, &vr, 1, &r)
    NC(SetInteger, &vr, 1, &i)
    NC(SetBoolean, &vr, 1, &b)
    NC(SetString, &vr, 1, &s)
    NC(GetFMUstate, &state)
    NC(SetFMUstate, odd)
    NC(SerializedFMUstateSize, odd, &n)
    NC(SerializeFMUstate, odd, blob, sizeof blob)
    NC(DeSerializeFMUstate, blob, sizeof blob, &state)
    mark("bad.no-component.FreeFMUstate");
    st = L.FreeFMUstate(NULL, &state);
    ck(st == fmi2Error || st == fmi2OK, "bad.no-component.FreeFMUstate", "expected fmi2Error or fmi2OK for no state, came %s", stname(st));
    NC(GetDirectionalDerivative, &vr, 1, &vr, 1, &r, &r)
    NC0(EnterEventMode)
    NC(NewDiscreteStates, &info)
    NC0(EnterContinuousTimeMode)
    NC(CompletedIntegratorStep, fmi2True, &b, &b2)
    NC(SetTime, 0.0)
    NC(SetContinuousStates, &r, 1)
    NC(GetDerivatives, &r, 1)
    NC(GetEventIndicators, &r, 1)
    NC(GetContinuousStates, &r, 1)
    NC(GetNominalsOfContinuousStates, &r, 1)
    NC(SetRealInputDerivatives, &vr, 1, &i, &r)
    NC(GetRealOutputDerivatives, &vr, 1, &i, &r)
    NC(DoStep, 0.0, 0.01, fmi2True)
    NC0(CancelStep)
    NC(GetStatus, fmi2DoStepStatus, &st)
    NC(GetRealStatus, fmi2LastSuccessfulTime, &r)
    NC(GetIntegerStatus, fmi2DoStepStatus, &i)
    NC(GetBooleanStatus, fmi2Terminated, &b)
    NC(GetStringStatus, fmi2PendingStatus, &s)
#undef NC
#undef NC0
    mark("bad.no-component.FreeInstance");
    L.FreeInstance(NULL);
    ck(1, "bad.no-component.FreeInstance", " ");
}

/* An instantiation that must give NULL and a sentence. */
static void no_instance(const char *name, const char *inst, const char *guid, const char *uri)
{
    mark(name);
    struct env *e = env_new(inst);
    fmi2Component c = instantiate(e, inst, fmi2CoSimulation, guid, uri, fmi2True);
    if (c) ck(0, name, "expected NULL, came an instance");
    else ck(e->sentences > 0, name, "expected a sentence in the log, came none");
    if (c) L.FreeInstance(c);
    env_free(e);
}

static void bad_instantiation(void)
{
    char *tmp = temp_dir(), *u;
    no_instance("bad.guid.wrong", "wheelset", "{00000000-0000-0000-0000-000000000000}", g_uri);
    no_instance("bad.guid.empty", "wheelset", "", g_uri);
    no_instance("bad.guid.null", "wheelset", NULL, g_uri);
    char *g = fmtdup("%s ", g_guid);
    no_instance("bad.guid.longer", "wheelset", g, g_uri);
    g[strlen(g_guid) - 1] = 0;
    no_instance("bad.guid.shorter", "wheelset", g, g_uri);
    free(g);
    no_instance("bad.name.null", NULL, g_guid, g_uri);
    no_instance("bad.name.empty", "", g_guid, g_uri);
    no_instance("bad.resources.null", "wheelset", g_guid, NULL);
    no_instance("bad.resources.empty-text", "wheelset", g_guid, "");
    no_instance("bad.resources.http", "wheelset", g_guid, "http://localhost/resources");
    no_instance("bad.resources.other-host", "wheelset", g_guid, "file://example.org/resources");
    no_instance("bad.resources.scheme-only", "wheelset", g_guid, "file:");
    no_instance("bad.resources.bad-percent", "wheelset", g_guid, "file:///tmp/%zz%");
    no_instance("bad.resources.zero-byte", "wheelset", g_guid, "file:///tmp%00/x");
    u = path_to_uri("file://", tmp, 0);
    no_instance("bad.resources.empty-folder", "wheelset", g_guid, u);
    free(u);
    char *p = fmtdup("%s/missing", tmp);
    u = path_to_uri("file://", p, 0);
    no_instance("bad.resources.missing-folder", "wheelset", g_guid, u);
    free(u);
    free(p);
    remove_tree(tmp);
    free(tmp);
}

/* One file of a copy of the resources, damaged in several ways. */
static void bad_file(const char *from, const char *rel)
{
    static const char *const ways[] = { "intact", "empty", "half", "last-byte-cut", "first-digit", "middle-digit",
                                        "last-digit", "longer", "missing" };
    char *tmp = temp_dir(), *file = fmtdup("%s/%s", tmp, rel), *uri = path_to_uri("file://", tmp, 0);
    size_t n = 0;
    char *text = NULL;
    if (!ck(!copy_tree(from, tmp) && (text = read_all(file, &n)) && n > 2, "bad.resources.copy",
            "expected a copy with %s, came an error", rel)) goto out;
    for (size_t w = 0; w < sizeof ways / sizeof *ways; w++) {
        char *t = xalloc(n + 2, 1), *name = fmtdup("bad.resources.%s.%s", rel, ways[w]);
        memcpy(t, text, n);
        size_t len = w == 1 ? 0 : w == 2 ? n / 2 : w == 3 ? n - 1 : n, at = 0;
        int found = 1;
        if (w >= 4 && w <= 6) {
            /* the first digit, the first past the middle, the last */
            size_t i = w == 5 ? n / 2 : 0;
            for (found = 0; i < n; i++)
                if (isdigit((unsigned char)t[i])) {
                    at = i;
                    found = 1;
                    if (w != 6) break;
                }
            if (found) t[at] = t[at] == '9' ? '1' : (char)(t[at] + 1);
        }
        if (w == 7) t[len++] = '\n';
        if (w == 8) unlink(file);
        else if (write_all(file, t, len)) ck(0, name, "expected to write, came an error");
        if (w == 0) {
            struct inst in;
            mark(name);
            ck(inst_open_at(&in, "intact", uri), name, "expected an instance, came NULL");
            inst_close(&in);
        } else if (found) {
            no_instance(name, "wheelset", g_guid, uri);
        }
        free(t);
        free(name);
    }
out:
    free(text);
    remove_tree(tmp);
    free(tmp);
    free(file);
    free(uri);
}

static void bad_callbacks(void)
{
    enum { N = 10 };
    double *a = xalloc((N + 1) * g_nout, sizeof *a), *b = xalloc((N + 1) * g_nout, sizeof *b);
    struct inst in;
    if (!inst_open(&in, "reference")) { free(a); free(b); return; }
    fmi2Status ref = THEN(start(&in, &PLAIN), run(&in, N, 0.01, a));
    inst_close(&in);

    mark("bad.callbacks.null-struct");
    fmi2Component c = L.Instantiate("bare", fmi2CoSimulation, g_guid, g_uri, NULL, fmi2False, fmi2True);
    if (c) L.FreeInstance(c);
    ck(1, "bad.callbacks.null-struct", " ");

    static const char *const names[] = { "bad.callbacks.no-logger", "bad.callbacks.no-allocators",
                                         "bad.callbacks.none", "bad.callbacks.no-memory" };
    for (int k = 0; k < 4; k++) {
        mark(names[k]);
        memset(&in, 0, sizeof in);
        in.e = env_new("bare");
        if (k == 0 || k == 2) in.e->cb.logger = NULL;
        if (k == 1 || k == 2) {
            in.e->cb.allocateMemory = NULL;
            in.e->cb.freeMemory = NULL;
            in.e->cb.stepFinished = NULL;
        }
        if (k == 3) in.e->cb.allocateMemory = no_alloc;
        in.c = instantiate(in.e, "bare", fmi2CoSimulation, g_guid, g_uri, fmi2True);
        if (k < 3 && !in.c) {
            ck(0, names[k], "expected an instance, came NULL");
        } else if (in.c) {
            fmi2Status st = THEN(ref, start(&in, &PLAIN));
            fmi2Status st2 = set_real(&in, unknown_vr(), 1.0);
            ck(refused(st2), names[k], "expected a refusal, came %s", stname(st2));
            st = THEN(st, run(&in, N, 0.01, b));
            ck_same(names[k], st, b, a, N + 1);
            ck_status(names[k], fmi2OK, L.Terminate(in.c));
        } else {
            ck(1, names[k], " ");
        }
        if (k == 0) {
            c = instantiate(in.e, "bare", fmi2CoSimulation, "wrong", g_uri, fmi2True);
            ck(!c, "bad.callbacks.no-logger.guid", "expected NULL, came an instance");
            if (c) L.FreeInstance(c);
        }
        inst_close(&in);
    }
    free(a);
    free(b);
}

static void mode_bad(int nfiles, char **files)
{
    bad_order();
    bad_variables();
    bad_steps();
    bad_null_pointers();
    bad_null_component();
    bad_instantiation();
    char *path = uri_to_path(g_uri), *real = realpath(path, NULL);
    if (ck(real != NULL, "bad.resources.path", "expected a folder behind the URI, came none at %s", path)) {
        bad_file(real, "scene.toml");
        for (int i = 0; i < nfiles; i++) bad_file(real, files[i]);
    }
    free(path);
    free(real);
    bad_callbacks();
}

/* ------------------------------------------------------------------ */
/* states                                                              */

enum { BEFORE = 55, AFTER = 40 };

/* Steps beside every round number, about 10 ms each. */
static double odd_step(int i) { return 0.0071 + 0.0013 * ((i * 7) % 5) + 1e-4 / (i + 3); }

/* The inputs of step i, changing inside of the disturbance. */
static fmi2Status odd_input(struct inst *in, int i)
{
    if (i % 8 != 5) return fmi2OK;
    return THEN(set1(in, K_TORQUE, 400.0 + 30.0 * i), set1(in, K_LATERAL, 1500.0 - 100.0 * (i % 16)));
}

/* Steps i0 .. i0+n-1, outputs before them and after each. */
static fmi2Status odd_run(struct inst *in, int i0, int n, double *trace)
{
    fmi2Status st = outputs(in, trace);
    for (int i = 0; i < n && st == fmi2OK; i++) {
        st = THEN(odd_input(in, i0 + i), step(in, odd_step(i0 + i)));
        if (st == fmi2OK) st = outputs(in, trace + (size_t)(i + 1) * g_nout);
    }
    return st;
}

/* Refused, with a sentence, and without a state. */
static int blob_refused(struct inst *in, const char *blob, size_t n, char **why)
{
    fmi2FMUstate s = NULL;
    long s0 = in->e->sentences;
    fmi2Status st = L.DeSerializeFMUstate(in->c, blob, n, &s);
    *why = st != fmi2Error ? fmtdup("%s", stname(st)) : s ? fmtdup("a state")
         : in->e->sentences == s0 ? fmtdup("no sentence in the log") : NULL;
    if (s) L.FreeFMUstate(in->c, &s);
    return !*why;
}

static void ck_blob(struct inst *in, const char *name, const char *blob, size_t n)
{
    char *why = NULL;
    mark(name);
    int ok = blob_refused(in, blob, n, &why);
    ck(ok, name, "expected fmi2Error, a sentence and no state, came %s", why ? why : "");
    free(why);
}

/* Several positions under one name: all must be refused. */
static void ck_flips(struct inst *in, const char *name, const char *blob, size_t n, size_t from, size_t to,
                     size_t stride)
{
    char *t = xalloc(n, 1), *why = NULL, *first = NULL;
    size_t bad = 0, at = 0, all = 0;
    mark(name);
    memcpy(t, blob, n);
    for (size_t i = from; i < to && i < n; i += stride)
        for (int k = 0; k < 2; k++) {
            t[i] = (char)(blob[i] ^ (k ? 0x80 : 0x01));
            all++;
            if (!blob_refused(in, t, n, &why)) {
                if (!bad++) { at = i; first = why; }
                else free(why);
            }
            t[i] = blob[i];
        }
    ck(!bad, name, "expected %zu changed bytes refused, came %zu others, first at %zu of %zu: %s", all, bad, at, n,
       first ? first : "");
    free(first);
    free(t);
}

static void states_damage(struct inst *in, const char *blob, size_t n)
{
    size_t head = n < 128 ? n : 128;
    ck_flips(in, "states.damage.header", blob, n, 0, head, 1);
    ck_flips(in, "states.damage.middle", blob, n, n / 2, n / 2 + 16, 1);
    ck_flips(in, "states.damage.end", blob, n, n > 32 ? n - 32 : 0, n, 1);
    ck_flips(in, "states.damage.sampled", blob, n, 3, n, n / 199 + 1);

    const size_t cut[] = { 1, 7, 8, 16, n / 4, n / 2, n - 8, n - 1 };
    for (size_t i = 0; i < sizeof cut / sizeof *cut; i++) {
        if (cut[i] >= n) continue;
        /* a buffer of just that size, so that reading on is seen */
        char *t = xalloc(cut[i], 1), *name = fmtdup("states.damage.cut-to-%zu", cut[i]);
        memcpy(t, blob, cut[i]);
        ck_blob(in, name, t, cut[i]);
        mark("states");
        free(t);
        free(name);
    }
    ck_blob(in, "states.damage.length-zero", blob, 0);
    char *t = xalloc(n + 4096, 1);
    memcpy(t, blob, n);
    ck_blob(in, "states.damage.one-longer", t, n + 1);
    ck_blob(in, "states.damage.longer", t, n + 4096);
    memcpy(t + n, blob, n < 4096 ? n : 4096);
    ck_blob(in, "states.damage.repeated", t, n + (n < 4096 ? n : 4096));
    memset(t, 0, n);
    ck_blob(in, "states.damage.zeros", t, n);
    memset(t, 0xff, n);
    ck_blob(in, "states.damage.ones", t, n);
    uint64_t x = 88172645463325252u;
    for (int k = 0; k < 8; k++) {
        for (size_t i = 0; i < n; i++) {
            x ^= x << 13;
            x ^= x >> 7;
            x ^= x << 17;
            t[i] = (char)(x >> 32);
        }
        ck_blob(in, "states.damage.random", t, n);
    }
    /* the GUID, if it stands there as text */
    const char *g = g_guid;
    size_t gl = strlen(g), hits = 0;
    if (gl > 2 && g[0] == '{') { g++; gl -= 2; }
    for (size_t i = 0; gl > 8 && i + gl <= n; i++)
        if (!memcmp(blob + i, g, gl)) {
            hits++;
            ck_flips(in, "states.damage.guid", blob, n, i, i + gl, 1);
            memcpy(t, blob, n);
            memset(t + i, '0', gl);
            ck_blob(in, "states.damage.guid-other", t, n);
        }
    if (!hits) note("the GUID does not stand as text in the serialized state");
    free(t);
}

/* The host frees the instance and leaves states behind: they are the instance's own, and a memory checker finds none of them. */
static void states_left(void)
{
    struct inst in, other;
    fmi2FMUstate s[3] = { NULL, NULL, NULL };
    mark("states.left");
    if (!ck(inst_open(&in, "leaves states"), "states.left", "expected an instance, came NULL")) return;
    for (int i = 0; i < 3; i++) ck_status("states.left", fmi2OK, THEN(i ? fmi2OK : start(&in, &PLAIN), L.GetFMUstate(in.c, &s[i])));
    if (ck(inst_open(&other, "foreign"), "states.foreign", "expected an instance, came NULL")) {
        fmi2FMUstate kept = s[0];
        ck_status("states.foreign", fmi2Error, L.FreeFMUstate(other.c, &s[0]));
        ck(s[0] == kept, "states.foreign", "expected the state to stay, came another pointer");
        inst_close(&other);
    }
    ck_status("states.left", fmi2OK, L.FreeFMUstate(in.c, &s[1]));
    inst_close(&in);
}

static void mode_states(void)
{
    states_left();
    size_t rows = AFTER + 1;
    double *want = xalloc(rows * g_nout, sizeof *want), *got = xalloc(rows * g_nout, sizeof *got);
    double *scrap = xalloc((BEFORE + 1) * g_nout, sizeof *scrap);
    struct inst in, other;
    fmi2FMUstate s = NULL, early = NULL, back = NULL;
    char *blob = NULL, *blob2 = NULL;
    size_t n = 0, m = 0;
    fmi2Status st;
    memset(&other, 0, sizeof other);

    mark("states.start");
    if (!ck(inst_open(&in, "stateful"), "states.instance", "expected an instance, came NULL")) goto out;
    ck_status("states.get-instantiated", fmi2OK, L.GetFMUstate(in.c, &early));
    st = THEN(start(&in, &PLAIN), odd_run(&in, 0, BEFORE, scrap));
    ck_status("states.run", fmi2OK, st);
    double t0 = in.t;
    ck(t0 > 0.5 && t0 < 0.6, "states.time", "expected a time in the disturbance, came %g", t0);

    mark("states.get");
    if (!ck_status("states.get", fmi2OK, L.GetFMUstate(in.c, &s)) ||
        !ck(s != NULL, "states.get", "expected a state, came NULL")) goto close;
    st = odd_run(&in, BEFORE, AFTER, want);
    ck_status("states.run-on", fmi2OK, st);

    /* back, right away and after other inputs and other steps */
    for (int k = 0; k < 4; k++) {
        static const char *const names[] = { "states.rollback", "states.rollback-again",
                                             "states.rollback-from-other-steps", "states.rollback-after-error" };
        mark(names[k]);
        if (k == 2) {
            L.SetFMUstate(in.c, s);
            in.t = t0;
            set1(&in, K_TORQUE, -3000.0);
            set1(&in, K_MU_L, 0.3);
            set_input_derivative(&in, g_key[K_LATERAL], 1, 1e4);
            for (int i = 0; i < 7; i++) step(&in, 0.0033);
            set_input_derivative(&in, g_key[K_LATERAL], 1, 2e4);
            set_input_derivative(&in, g_key[K_LATERAL], 2, 2e5);
        }
        if (k == 3) {
            L.DoStep(in.c, in.t, -1.0, fmi2True);
            set_real(&in, unknown_vr(), 1.0);
        }
        st = L.SetFMUstate(in.c, s);
        in.t = t0;
        double tl = NAN;
        L.GetRealStatus(in.c, fmi2LastSuccessfulTime, &tl);
        ck(fabs(tl - t0) < 1e-9, "states.rollback-time", "expected %.17g, came %.17g", t0, tl);
        st = THEN(st, odd_run(&in, BEFORE, AFTER, got));
        ck_same(names[k], st, got, want, rows);
    }

    mark("states.serialize");
    ck_status("states.size", fmi2OK, L.SerializedFMUstateSize(in.c, s, &n));
    if (!ck(n > 0, "states.size", "expected a size, came 0")) goto close;
    blob = xalloc(n, 1);
    blob2 = xalloc(n, 1);
    memset(blob2, 0x55, n);
    ck_status("states.serialize", fmi2OK, L.SerializeFMUstate(in.c, s, blob, n));
    ck_status("states.serialize-again", fmi2OK, L.SerializeFMUstate(in.c, s, blob2, n));
    ck(!memcmp(blob, blob2, n), "states.serialize-equal", "expected equal bytes twice, came different ones");
    const size_t small[] = { 0, 1, n / 2, n - 1 };
    for (size_t i = 0; i < sizeof small / sizeof *small; i++) {
        char *t = xalloc(small[i], 1), *name = fmtdup("states.serialize-into-%zu", small[i]);
        long s0 = in.e->sentences;
        mark(name);
        st = L.SerializeFMUstate(in.c, s, t, small[i]);
        ck(st == fmi2Error && in.e->sentences > s0, name, "expected fmi2Error and a sentence, came %s", stname(st));
        mark("states");
        free(t);
        free(name);
    }

    mark("states.deserialize-same");
    if (ck_status("states.deserialize-same", fmi2OK, L.DeSerializeFMUstate(in.c, blob, n, &back)) && back) {
        ck_status("states.size-of-copy", fmi2OK, L.SerializedFMUstateSize(in.c, back, &m));
        ck(m == n && L.SerializeFMUstate(in.c, back, blob2, n) == fmi2OK && !memcmp(blob, blob2, n),
           "states.serialize-copy", "expected the same %zu bytes again, came others (%zu)", n, m);
        st = L.SetFMUstate(in.c, back);
        in.t = t0;
        st = THEN(st, odd_run(&in, BEFORE, AFTER, got));
        ck_same("states.deserialize-same", st, got, want, rows);
        st = L.FreeFMUstate(in.c, &back);
        ck(st == fmi2OK && !back, "states.free", "expected fmi2OK and a NULL state, came %s", stname(st));
    }

    /* into other instances: new, in initialization, stepping with other values */
    for (int k = 0; k < 3; k++) {
        static const char *const names[] = { "states.deserialize-new", "states.deserialize-initialization",
                                             "states.deserialize-stepping" };
        mark(names[k]);
        if (!ck(inst_open(&other, "second"), names[k], "expected an instance, came NULL")) continue;
        struct scen o = PLAIN;
        o.y0 = -2e-3;
        o.torque = -100;
        st = fmi2OK;
        if (k == 1) st = THEN(setup(&other, &o), L.EnterInitializationMode(other.c));
        if (k == 2) st = THEN(start(&other, &o), odd_run(&other, 0, 9, got));
        back = NULL;
        st = THEN(st, L.DeSerializeFMUstate(other.c, blob, n, &back));
        if (st == fmi2OK && back) {
            st = L.SetFMUstate(other.c, back);
            other.t = t0;
            st = THEN(st, odd_run(&other, BEFORE, AFTER, got));
        }
        ck_same(names[k], st, got, want, rows);
        if (back) L.FreeFMUstate(other.c, &back);
        inst_close(&other);
    }

    /* a reset in between; a state of the beginning */
    mark("states.reset");
    ck_status("states.reset", fmi2OK, L.Reset(in.c));
    st = L.SetFMUstate(in.c, s);
    in.t = t0;
    st = THEN(st, odd_run(&in, BEFORE, AFTER, got));
    ck_same("states.after-reset", st, got, want, rows);
    if (early) {
        mark("states.instantiated");
        st = L.SetFMUstate(in.c, early);
        st = THEN(st, THEN(start(&in, &PLAIN), odd_run(&in, 0, BEFORE, scrap)));
        st = THEN(st, odd_run(&in, BEFORE, AFTER, got));
        ck_same("states.back-to-instantiated", st, got, want, rows);
        L.FreeFMUstate(in.c, &early);
    }
    mark("states.after-terminate");
    ck_status("states.terminate", fmi2OK, L.Terminate(in.c));
    st = L.SetFMUstate(in.c, s);
    if (st == fmi2OK) {
        in.t = t0;
        st = odd_run(&in, BEFORE, AFTER, got);
        ck_same("states.after-terminate", st, got, want, rows);
    } else {
        /* the standard leaves this open: come back by a reset */
        ck(refused(st), "states.after-terminate", "expected fmi2OK or a refusal, came %s", stname(st));
        L.Reset(in.c);
        L.SetFMUstate(in.c, s);
    }

    /* an existing state is overwritten */
    mark("states.reuse");
    fmi2FMUstate reused = NULL, zero = NULL;
    L.SetFMUstate(in.c, s);
    in.t = t0;
    step(&in, 0.02);
    ck_status("states.reuse-first", fmi2OK, L.GetFMUstate(in.c, &reused));
    L.SetFMUstate(in.c, s);
    in.t = t0;
    ck_status("states.reuse-second", fmi2OK, L.GetFMUstate(in.c, &reused));
    step(&in, 0.03);
    st = L.SetFMUstate(in.c, reused);
    in.t = t0;
    st = THEN(st, odd_run(&in, BEFORE, AFTER, got));
    ck_same("states.reuse", st, got, want, rows);
    ck_status("states.reuse-free", fmi2OK, L.FreeFMUstate(in.c, &reused));
    ck_status("states.free-null", fmi2OK, L.FreeFMUstate(in.c, &zero));

    /* many at once, freed in another order */
    mark("states.many");
    enum { MANY = 20 };
    fmi2FMUstate many[MANY] = { 0 };
    double at[MANY];
    L.SetFMUstate(in.c, s);
    in.t = t0;
    st = fmi2OK;
    for (int i = 0; i < MANY; i++) {
        at[i] = in.t;
        st = THEN(st, L.GetFMUstate(in.c, &many[i]));
        st = THEN(st, THEN(odd_input(&in, BEFORE + i), step(&in, odd_step(BEFORE + i))));
    }
    ck_status("states.many", fmi2OK, st);
    int good = 1;
    for (int i = MANY - 1; i >= 0 && st == fmi2OK; i--) {
        st = L.SetFMUstate(in.c, many[i]);
        in.t = at[i];
        st = THEN(st, outputs(&in, got));
        good &= same(got, want + (size_t)i * g_nout, 1);
        st = THEN(st, THEN(odd_input(&in, BEFORE + i), step(&in, odd_step(BEFORE + i))));
        st = THEN(st, outputs(&in, got));
        good &= same(got, want + (size_t)(i + 1) * g_nout, 1);
    }
    ck(good && st == fmi2OK, "states.many-backwards", "expected the outputs of the first run, came others with %s", stname(st));
    for (int i = 0; i < MANY; i++) L.FreeFMUstate(in.c, &many[(i * 7) % MANY]);

    /* damaged bytes, and the instance after all of them */
    mark("states.damage");
    L.SetFMUstate(in.c, s);
    in.t = t0;
    states_damage(&in, blob, n);
    mark("states.damage.after");
    st = odd_run(&in, BEFORE, AFTER, got);
    ck_same("states.damage.after", st, got, want, rows);

close:
    mark("states.end");
    if (s) L.FreeFMUstate(in.c, &s);
    if (early) L.FreeFMUstate(in.c, &early);
    inst_close(&in);
out:
    free(want);
    free(got);
    free(scrap);
    free(blob);
    free(blob2);
}


/* ------------------------------------------------------------------ */

static int load_library(const char *file, void **handle, int quiet)
{
    mark("dlopen");
    *handle = dlopen(file, RTLD_NOW | RTLD_LOCAL);
    if (!*handle) return ck(0, "library", "expected a loadable library, came %s", dlerror());
    int all = 1;
    void *p;
#define X(n)                                                                       \
    p = dlsym(*handle, "fmi2" #n);                                                 \
    memcpy(&L.n, &p, sizeof p);                                                    \
    if (!p || !quiet) ck(p != NULL, "symbol fmi2" #n, "expected the function, came none"); \
    all &= p != NULL;
    FMI_FUNCTIONS(X)
#undef X
    return all;
}

static int usage(void)
{
    fputs("usage: fmi2_host MODE LIBRARY RESOURCE_URI GUID VARIABLES [extra...]\n"
          "  abi [LOG_CATEGORY...]\n"
          "  bad [RESOURCE_FILE...]      more files to damage, beside scene.toml\n"
          "  states\n"
          "  threads N\n"
          "  urls\n"
          "  bench STEP STOP\n"
          "  csv STEPFILE OUT [NAME=VALUE...]\n", stderr);
    return 2;
}

static int positive(const char *s, double *v)
{
    char *end;
    *v = strtod(s, &end);
    return end != s && !*end && isfinite(*v) && *v > 0;
}

int main(int argc, char **argv)
{
    if (argc < 6) return usage();
    setvbuf(stdout, NULL, _IOLBF, 0);
    const char *mode = argv[1];
    int extra = argc - 6;
    char **x = argv + 6;
    double a = 0, b = 0;
    if (!strcmp(mode, "states") || !strcmp(mode, "urls")) {
        if (extra) return usage();
    } else if (!strcmp(mode, "threads")) {
        if (extra != 1 || !positive(x[0], &a) || a > 200 || a != floor(a)) return usage();
    } else if (!strcmp(mode, "bench")) {
        if (extra != 2 || !positive(x[0], &a) || !positive(x[1], &b) || b < a) return usage();
    } else if (!strcmp(mode, "csv")) {
        if (extra < 2) return usage();
    } else if (strcmp(mode, "abi") && strcmp(mode, "bad")) {
        return usage();
    }
    g_uri = argv[3];
    g_guid = argv[4];
    g_verbose = getenv("FMI2_HOST_VERBOSE") != NULL;
    if (load_vars(argv[5])) { free_vars(); return 2; }

    const int sigs[] = { SIGSEGV, SIGBUS, SIGABRT, SIGFPE, SIGILL, SIGALRM };
    for (size_t i = 0; i < sizeof sigs / sizeof *sigs; i++) signal(sigs[i], on_signal);

    void *lib = NULL;
    int quiet = strcmp(mode, "abi") != 0, csv = !strcmp(mode, "csv"), rc = 0;
    if (load_library(argv[2], &lib, quiet) && (csv || check_known(quiet))) {
        if (!strcmp(mode, "abi")) mode_abi(extra, x);
        else if (!strcmp(mode, "bad")) mode_bad(extra, x);
        else if (!strcmp(mode, "states")) mode_states();
        else if (!strcmp(mode, "threads")) mode_threads((int)a);
        else if (!strcmp(mode, "urls")) mode_urls();
        else if (!strcmp(mode, "bench")) mode_bench(a, b);
        else rc = mode_csv(x[0], x[1], extra - 2, x + 2);
        callback_checks();
    }
    mark("dlclose");
    if (lib && !getenv("FMI2_HOST_KEEP_LIBRARY") && dlclose(lib)) ck(0, "dlclose", "expected success, came %s", dlerror());
    free_vars();
    if (rc) return rc;
    printf("%s: %ld ok, %ld failed\n", mode, g_ok, g_fail);
    return g_fail ? 1 : 0;
}
