"""One thread of linear algebra for each item of a work, however many the process has."""

from workbench.design.matrices import libraries
from workbench.study.study_works import Work, compile_work


def threads_of_blas():
    """The numbers of threads that the BLAS of NumPy and that of SciPy have in this thread."""
    return {one["num_threads"] for one in libraries().info() if one["user_api"] == "blas"}


def seen(item: int) -> int:
    """The item times the largest number of threads that its linear algebra has."""
    return item * max(threads_of_blas())


def test_an_item_of_a_work_computes_by_one_thread_of_linear_algebra_and_leaves_the_others_as_they_were():
    work = compile_work(Work("seen", seen, over=(1,)))
    with libraries().limit(limits=2, user_api="blas"):
        before = threads_of_blas()
        assert work.answers(lambda name: work.chunk(0, 1)) == (1,)
        assert threads_of_blas() == before
