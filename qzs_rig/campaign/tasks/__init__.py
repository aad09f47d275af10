"""What campaigns compute: one file a task, one line in the table."""

from __future__ import annotations

from qzs_rig.campaign.task import Task
from qzs_rig.campaign.tasks import design, frf, lyapunov, run, single_term, statics, strobe, trace

TASKS: dict[str, Task] = {
    task.name: task
    for task in (
        statics.TASK,
        single_term.TASK,
        frf.TASK,
        trace.TASK,
        strobe.TASK,
        lyapunov.TASK,
        run.TASK,
        design.TASK,
    )
}
