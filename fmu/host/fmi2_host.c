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
    long percents;    /* formatted texts with a percent sign */
    char last[1024];
};

static struct env g_envs[MAX_ENVS];
static pthread_mutex_t g_env_lock = PTHREAD_MUTEX_INITIALIZER;
static atomic_long g_bad_env, g_bad_name, g_stray, g_bad_category, g_bad_message, g_stale,
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
    if (strchr(e->last, '%')) e->percents++;
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
    st = worse(st, setup(in, s));
    st = worse(st, L.EnterInitializationMode(in->c));
    st = worse(st, set_inputs(in, s));
    return worse(st, L.ExitInitializationMode(in->c));
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
        fmi2Status st = worse(start(&in, &s), run(&in, N, 0.01, a));
        ck_status(names[k], fmi2OK, st);
        ck(all_finite(a, (N + 1) * g_nout), names[k], "expected finite outputs, came others");
        ck_status("abi.terminate", fmi2OK, L.Terminate(in.c));
        if (k == 0) {
            mark("abi.reset");
            ck_status("abi.reset.after-terminate", fmi2OK, L.Reset(in.c));
            st = worse(start(&in, &s), run(&in, N, 0.01, b));
            ck_same("abi.reset.again", st, b, a, N + 1);
            ck_status("abi.reset.while-stepping", fmi2OK, L.Reset(in.c));
            st = worse(start(&in, &s), run(&in, N, 0.01, b));
            ck_same("abi.reset.again2", st, b, a, N + 1);

            /* after a reset all start values hold again */
            ck_status("abi.reset.3", fmi2OK, L.Reset(in.c));
            st = worse(start(&in, &UNTOUCHED), run(&in, N, 0.01, b));
            if (inst_open(&other, "wheelset 2")) {
                fmi2Status st2 = worse(start(&other, &UNTOUCHED), run(&other, N, 0.01, a));
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
            st = worse(start(&in, &UNTOUCHED), run(&in, N, 0.01, b));
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
        fmi2Status st = worse(start(&in, &PLAIN), run(&in, N, 0.01, a));
        inst_close(&in);
        if (inst_open(&in, "wheelset 4")) {
            st = worse(st, start(&in, &PLAIN));
            for (int i = 0; i < N; i++) st = worse(st, L.DoStep(in.c, i * 0.01, 0.01, fmi2False));
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
        fmi2Status st = worse(start(&in, &s), run(&in, 10, 0.01, a));
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
        double zero = 0;
        fmi2Status st = worse(start(&in, &UNTOUCHED), set_parameters(&off, &s));
        st = worse(st, setup(&off, &s));
        st = worse(st, L.EnterInitializationMode(off.c));
        st = worse(st, set1(&off, K_TORQUE, zero));
        st = worse(st, L.ExitInitializationMode(off.c));
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
        fmi2Status st = worse(start(&in, &PLAIN), setup(&off, &PLAIN));
        st = worse(st, L.EnterInitializationMode(off.c));
        st = worse(st, set_parameters(&off, &PLAIN));
        st = worse(st, set_inputs(&off, &PLAIN));
        st = worse(st, L.ExitInitializationMode(off.c));
        st = worse(st, worse(run(&in, 10, 0.01, a), run(&off, 10, 0.01, b)));
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
    long percents = 0;
    mark("abi.percent");
    if (ck(inst_open(&in, name), "abi.percent.name", "expected an instance, came NULL")) {
        fmi2ValueReference none = 4294967295u;
        double v;
        L.GetReal(in.c, &none, 1, &v);
        ck(in.e->sentences > 0, "abi.percent.log", "expected a sentence, came none");
        percents += in.e->percents;
        inst_close(&in);
    }
    struct env *e = env_new(name);
    fmi2Component c = instantiate(e, name, fmi2CoSimulation, "{%s%n%d-100%}", g_uri, fmi2True);
    ck(!c && e->sentences > 0, "abi.percent.guid", "expected NULL and a sentence, came %s and %ld", c ? "an instance" : "NULL", e->sentences);
    if (c) L.FreeInstance(c);
    c = instantiate(e, name, fmi2CoSimulation, g_guid, "file:///no%25s%25n/such%20folder", fmi2True);
    ck(!c, "abi.percent.uri", "expected NULL, came an instance");
    if (c) L.FreeInstance(c);
    percents += e->percents;
    env_free(e);
    if (!percents) note("no message with a percent sign was ever logged");
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
    j->st = j->in.c ? worse(start(&j->in, &s), run(&j->in, THREAD_STEPS, 0.01, j->trace)) : fmi2Fatal;
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
        fmi2Status st = worse(start(&in, &PLAIN), run(&in, 10, 0.01, a));
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
}

static void mode_urls(void)
{
    struct inst in;
    double *want = xalloc(11 * g_nout, sizeof *want);
    mark("urls.as-given");
    if (ck(inst_open(&in, "as given"), "urls.as-given", "expected an instance, came NULL")) {
        ck_status("urls.as-given", fmi2OK, worse(start(&in, &PLAIN), run(&in, 10, 0.01, want)));
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
        fmi2Status st = worse(start(&in, &s), outputs(&in, v));
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
                st = worse(L.DoStep(in.c, t, h, fmi2True), outputs(&in, v));
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

static void mode_bad(int n, char **x) { (void)n; (void)x; ck(0, "bad", "not written"); }
static void mode_states(void) { ck(0, "states", "not written"); }

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
    if (lib && dlclose(lib)) ck(0, "dlclose", "expected success, came %s", dlerror());
    free_vars();
    if (rc) return rc;
    printf("%s: %ld ok, %ld failed\n", mode, g_ok, g_fail);
    return g_fail ? 1 : 0;
}
