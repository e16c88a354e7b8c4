/* Preloaded: the process whose command line has KILL_PROGRAM in it kills itself at its KILL_AT-th write to a file or a
   socket, before it or, where the number is even, in the middle of it. Once: KILL_FLAG is a file that says that it was
   done. Without KILL_AT it adds a byte to KILL_LOG for each, so that they can be counted. */
#define _GNU_SOURCE
#include <dlfcn.h>
#include <fcntl.h>
#include <signal.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <unistd.h>

static atomic_long count;
static long kill_at = -1;
static const char *log_file;

__attribute__((constructor)) static void begin(void) {
    const char *program = getenv("KILL_PROGRAM"), *at = getenv("KILL_AT");
    char words[8192] = {0};
    int file = open("/proc/self/cmdline", O_RDONLY);
    long length = file < 0 ? 0 : read(file, words, sizeof words - 1);
    if (file >= 0) close(file);
    for (long i = 0; i + 1 < length; i++)
        if (!words[i]) words[i] = ' ';
    if (!program || !strstr(words, program)) return;
    if (at && !access(getenv("KILL_FLAG"), F_OK)) return; /* brought back, it writes as always */
    kill_at = at ? atol(at) : 0;
    log_file = getenv("KILL_LOG");
}

/* Whether to die now; the number of this write. */
static long due(void) {
    if (kill_at < 0) return 0;
    long here = ++count;
    if (!kill_at && log_file) {
        int file = open(log_file, O_WRONLY | O_CREAT | O_APPEND, 0600);
        syscall(SYS_write, file, ".", 1);
        close(file);
    }
    return here == kill_at ? here : 0;
}

static void die(void) {
    int file = open(getenv("KILL_FLAG"), O_WRONLY | O_CREAT | O_EXCL, 0600);
    if (file >= 0) syscall(SYS_kill, getpid(), SIGKILL);
    kill_at = -1;
}

static int counts(int file) {
    struct stat about;
    return kill_at >= 0 && file > 2 && !fstat(file, &about) && (S_ISREG(about.st_mode) || S_ISSOCK(about.st_mode));
}

#define NEXT(name) ((__typeof__(&name))dlsym(RTLD_NEXT, #name))

ssize_t write(int file, const void *data, size_t size) {
    if (counts(file)) {
        long here = due();
        if (here && here % 2 == 0) syscall(SYS_write, file, data, size / 2);
        if (here) die();
    }
    return NEXT(write)(file, data, size);
}

ssize_t send(int file, const void *data, size_t size, int flags) {
    if (counts(file) && due()) die();
    return NEXT(send)(file, data, size, flags);
}

ssize_t sendmsg(int file, const struct msghdr *message, int flags) {
    if (counts(file) && due()) die();
    return NEXT(sendmsg)(file, message, flags);
}

int rename(const char *from, const char *to) {
    if (kill_at >= 0 && due()) die();
    return NEXT(rename)(from, to);
}

int fsync(int file) {
    if (counts(file) && due()) die();
    return NEXT(fsync)(file);
}
