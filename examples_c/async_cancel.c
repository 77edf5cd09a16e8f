/*
 * Plan in the background, watch it, and stop it from another thread, as an emergency stop would.
 *
 *   cc -std=c11 -pthread -Iinclude examples_c/async_cancel.c -Ltarget/release -ljostle -lm
 */
#include <jostle/jostle.h>

#include <stdio.h>
#include <threads.h>
#include <time.h>

#define TRY(call)                                                                                                      \
    do {                                                                                                               \
        if ((call) != JOSTLE_OK) {                                                                                     \
            fprintf(stderr, "%s\n  %s\n", #call, jostle_last_error());                                                 \
            goto done;                                                                                                 \
        }                                                                                                              \
    } while (0)

static double seconds(void)
{
    struct timespec now;
    timespec_get(&now, TIME_UTC);
    return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

static void pause_ms(long milliseconds)
{
    thrd_sleep(&(struct timespec){.tv_nsec = milliseconds * 1000000}, NULL);
}

struct button {
    jostle_cancel *flag;
    double pressed_at;
};

/* The thread of the emergency stop has its own handle to the flag. */
static int press(void *argument)
{
    struct button *button = argument;
    pause_ms(150);
    button->pressed_at = seconds();
    return jostle_cancel_trigger(button->flag) == JOSTLE_OK ? 0 : 1;
}

int main(void)
{
    jostle_context *context = NULL;
    jostle_scene *scene = NULL;
    jostle_planner *planner = NULL;
    jostle_job *job = NULL;
    jostle_plan *plan = NULL;
    jostle_cancel *flag = NULL;
    struct button button = {NULL, 0};
    jostle_body target;
    thrd_t thread;
    int good = 0;

    TRY(jostle_abi_check(JOSTLE_ABI_VERSION));
    printf("%s\n", jostle_build_info());
    TRY(jostle_context_new(NULL, &context));
    TRY(jostle_scene_generate(context, 7, 0, 12, &scene, &target));

    jostle_planner_options options = jostle_planner_options_default();
    options.max_seconds = 60;     /* far more than it will get */
    options.execute_score = 1;    /* and it is not to be content with a grasp */
    options.solved_score = 1;
    TRY(jostle_planner_new(context, &options, &planner));

    TRY(jostle_cancel_new(context, &flag));
    TRY(jostle_cancel_clone(flag, &button.flag));
    jostle_solve_options solve = jostle_solve_options_default();
    solve.cancel = flag;
    TRY(jostle_planner_job_start(planner, scene, target, &solve, &job));
    if (thrd_create(&thread, press, &button) != thrd_success) goto done;

    jostle_job_state state = JOSTLE_JOB_RUNNING;
    uint64_t before = 0;
    int forward = 1;
    while (state == JOSTLE_JOB_RUNNING) { /* a control loop has other things to do here */
        jostle_progress now = jostle_progress_default();
        TRY(jostle_job_poll(job, &state, &now));
        forward = forward && now.iterations >= before;
        before = now.iterations;
        if (state == JOSTLE_JOB_RUNNING) TRY(jostle_job_wait(job, 0.01, &state));
    }
    double returned_at = seconds();
    if (thrd_join(thread, &(int){0}) != thrd_success) goto done;

    jostle_outcome outcome;
    size_t actions;
    TRY(jostle_job_take_plan(job, &plan));
    TRY(jostle_plan_outcome(plan, &outcome));
    TRY(jostle_plan_action_count(plan, &actions));
    printf("outcome: %s, %u actions\n", jostle_outcome_name(outcome), (unsigned)actions);
    printf("progress went forward: %s\n", forward ? "yes" : "no");
    double latency = returned_at - button.pressed_at;
    printf("cancel to return: %s\n", latency < 0.1 ? "below 100 ms" : "too long");
    fprintf(stdout, "# %.2f ms, %llu iterations\n", latency * 1e3, (unsigned long long)before);
    good = outcome == JOSTLE_OUTCOME_CANCELLED && actions == 0 && forward;

done:
    jostle_plan_free(plan);
    jostle_job_free(job); /* would cancel it and wait, were it running still */
    jostle_cancel_free(button.flag);
    jostle_cancel_free(flag);
    jostle_planner_free(planner);
    jostle_scene_free(scene);
    jostle_context_free(context);
    return good ? 0 : 1;
}
