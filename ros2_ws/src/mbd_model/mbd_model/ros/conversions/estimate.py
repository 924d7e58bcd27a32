"""Between mappings with their confidence and mbd_msgs/MappingEstimate."""

from __future__ import annotations

from builtin_interfaces.msg import Time
from mbd_msgs import msg as m
from std_msgs.msg import Header

from mbd_model.estimate import EstimateInputs, Feature, Mapping, MappingEstimate, QuestionKind
from mbd_model.ros.conversions.assist import assist_from_msg, assist_to_msg
from mbd_model.ros.conversions.times import stamp_from_msg

KIND_TO_CODE = {
    QuestionKind.WHAT_NEXT: m.MappingEstimate.WHAT_NEXT,
    QuestionKind.IS_THIS_IT: m.MappingEstimate.IS_THIS_IT,
    QuestionKind.WHICH_OF_TWO: m.MappingEstimate.WHICH_OF_TWO,
    QuestionKind.IS_THAT_SO: m.MappingEstimate.IS_THAT_SO,
}
# A version without the field knew open questions only.
CODE_TO_KIND = {m.MappingEstimate.QUESTION_UNKNOWN: QuestionKind.WHAT_NEXT, **{c: k for k, c in KIND_TO_CODE.items()}}


def mapping_to_msg(value: Mapping) -> m.Mapping:
    """One mapping."""
    return m.Mapping(
        pairs=[m.Correspondence(source_id=source, target_id=target) for source, target in value.pairs],
        score=value.score,
    )


def mapping_from_msg(msg: m.Mapping) -> Mapping:
    """One mapping."""
    return Mapping(pairs=tuple((p.source_id, p.target_id) for p in msg.pairs), score=float(msg.score))


def estimate_to_msg(
    value: MappingEstimate, *, session: str, threshold: float, stamps: tuple[Time, Time, Time]
) -> m.MappingEstimate:
    """An estimate with the stamps (task, target scene, assists) of the inputs it came from.

    Its own stamp is the latest of those, never the wall clock: the output is a pure function of the inputs.
    """
    return m.MappingEstimate(
        header=Header(stamp=max(stamps, key=lambda t: (t.sec, t.nanosec))),
        session=session,
        strategy=value.strategy,
        mapping=mapping_to_msg(value.mapping),
        confidence=value.confidence,
        threshold=threshold,
        confident=bool(value.mapping.pairs)
        and value.doubted is None
        and value.ties <= 1
        and value.confidence >= threshold,
        winning=[str(f) for f in value.winning],
        runner_up=[str(f) for f in value.runner_up],
        alternatives=[mapping_to_msg(a) for a in value.alternatives],
        ties=value.ties,
        num_assists=value.num_assists,
        warnings=list(value.warnings),
        next_question=value.next_question,
        information_gain=value.information_gain,
        task_stamp=stamps[0],
        scene_stamp=stamps[1],
        assists_stamp=stamps[2],
        best_guess=mapping_to_msg(value.best_guess),
        obeying=mapping_to_msg(value.obeying),
        doubted=assist_to_msg(value.doubted) if value.doubted else m.Assist(),
        doubt=value.doubt,
        question_kind=KIND_TO_CODE[value.question_kind],
        question_targets=list(value.question_targets),
    )


def estimate_from_msg(msg: m.MappingEstimate) -> MappingEstimate:
    """An estimate, without its stamps; raises ValueError for a feature or a kind of question there is not."""
    return MappingEstimate(
        strategy=msg.strategy,
        mapping=mapping_from_msg(msg.mapping),
        confidence=float(msg.confidence),
        winning=tuple(Feature(f) for f in msg.winning),
        runner_up=tuple(Feature(f) for f in msg.runner_up),
        alternatives=tuple(mapping_from_msg(a) for a in msg.alternatives),
        ties=int(msg.ties),
        num_assists=int(msg.num_assists),
        warnings=tuple(msg.warnings),
        next_question=msg.next_question,
        information_gain=float(msg.information_gain),
        best_guess=mapping_from_msg(msg.best_guess),
        obeying=mapping_from_msg(msg.obeying),
        doubted=assist_from_msg(msg.doubted) if msg.doubted.source_id else None,
        doubt=float(msg.doubt),
        question_kind=_question_kind(msg.question_kind),
        question_targets=tuple(msg.question_targets),
        threshold=float(msg.threshold),
    )


def _question_kind(code: int) -> QuestionKind:
    if code not in CODE_TO_KIND:
        raise ValueError(f"question_kind is {code}; expected one of {sorted(CODE_TO_KIND)}, see MappingEstimate.msg")
    return CODE_TO_KIND[code]


def inputs_from_msg(msg: m.MappingEstimate) -> EstimateInputs:
    """Which inputs an estimate came from."""
    return EstimateInputs(
        task_stamp=stamp_from_msg(msg.task_stamp),
        scene_stamp=stamp_from_msg(msg.scene_stamp),
        assists_stamp=stamp_from_msg(msg.assists_stamp),
        threshold=float(msg.threshold),
        confident=bool(msg.confident),
    )
