/* What newlib asks of an operating system, for a program without one: a heap behind the data, and no files. */
#include <stddef.h>
#include <sys/stat.h>

extern char bss_end[];
static size_t used;

void *__dso_handle = NULL;

size_t heap_in_use(void) { return used; }

void *_sbrk(ptrdiff_t more)
{
    char *const place = bss_end + used;
    used += (size_t)more;
    return place;
}

int _open(const char *name, int flags, int mode) { (void)name, (void)flags, (void)mode; return -1; }
int _close(int file) { (void)file; return -1; }
int _read(int file, char *to, int bytes) { (void)file, (void)to, (void)bytes; return 0; }
int _write(int file, char *from, int bytes) { (void)file, (void)from; return bytes; }
int _lseek(int file, int place, int from) { (void)file, (void)place, (void)from; return 0; }
int _fstat(int file, struct stat *status) { (void)file, (void)status; return -1; }
int _isatty(int file) { (void)file; return 1; }
int _unlink(const char *name) { (void)name; return -1; }
int _kill(int process, int signal) { (void)process, (void)signal; return -1; }
int _getpid(void) { return 1; }
int getentropy(void *to, size_t bytes) { (void)to, (void)bytes; return -1; }
void _exit(int status) { (void)status; for (;;) {} }
