/PROG  SCHIENE_Z_NZDJWO
/ATTR
OWNER		= MNEDITOR;
COMMENT		= "elastocal";
PROG_SIZE	= 0;
CREATE		= DATE 00-01-01  TIME 00:00:00;
MODIFIED	= DATE 00-01-01  TIME 00:00:00;
FILE_NAME	= ;
VERSION		= 0;
LINE_COUNT	= 94;
MEMORY_SIZE	= 0;
PROTECT		= READ_WRITE;
TCD:  STACK_SIZE	= 0,
      TASK_PRIORITY	= 50,
      TIME_SLICE	= 0,
      BUSY_LAMP_OFF	= 0,
      ABORT_REQUEST	= 0,
      PAUSE_REQUEST	= 0;
DEFAULT_GROUP	= 1,*,*,*,*;
CONTROL_CODE	= 00000000 00000000;
/MN
   1:  !Calibration campaign: 3 ;
   2:  !experiments in 2 configurations. ;
   3:  !Made by elastocal 0.1.0 from ;
   4:  !Schiene - Zelle 3 (Sud). ;
   5:  !plan sha256 0123456789abcdef ;
   6:  !Start: load all of ;
   7:  !SCHIENE_Z_NZDJWO, select ;
   8:  !SCHIENE_Z_NZDJWO, run it in T1 ;
   9:  !first. ;
  10:  !Robot: arm on a rail. Joint ;
  11:  !values: deg, mm, as in the ;
  12:  !model. ;
  13:  !Forces act at the load point of ;
  14:  !the tool, in the axes of the ;
  15:  !robot base. ;
  16:  !SAFETY: check this program at ;
  17:  !low speed in manual mode first. ;
  18:  !Motions between the points are ;
  19:  !not checked for collisions by ;
  20:  !this file. ;
  21:  !Set the payload of the empty ;
  22:  !calibration tool and leave it ;
  23:  !so, loaded and unloaded: the ;
  24:  !controller must not compensate ;
  25:  !what is to be measured. ;
  26:  !elastocal program 000000000000 ;
  27:  UFRAME_NUM=0 ;
  28:  UTOOL_NUM=1 ;
  29:  !to H0 ;
  30:J P[1] 25% FINE    ;
  31:  !to AP1 ;
  32:J P[2] 25% FINE    ;
  33:  !to P1 ;
  34:J P[3] 25% FINE    ;
  35:  WAIT   2.00(sec) ;
  36:  MESSAGE[Experiment 1/3: pose 1.] ;
  37:  MESSAGE[NO load. Measure M1.] ;
  38:  PAUSE ;
  39:  MESSAGE[Experiment 1/3: apply] ;
  40:  MESSAGE[374.63 N, Fx 100 Fy] ;
  41:  MESSAGE[-200.5 Fz -300.25 N.] ;
  42:  PAUSE ;
  43:  WAIT   2.00(sec) ;
  44:  MESSAGE[Experiment 1/3: pose 1.] ;
  45:  MESSAGE[LOADED. Measure M1.] ;
  46:  PAUSE ;
  47:  MESSAGE[Experiment 1/3: take the] ;
  48:  MESSAGE[load off. The robot] ;
  49:  MESSAGE[moves next.] ;
  50:  PAUSE ;
  51:  !to AP2 ;
  52:J P[4] 25% FINE    ;
  53:  !to P2 ;
  54:J P[5] 25% FINE    ;
  55:  WAIT   2.00(sec) ;
  56:  MESSAGE[Experiment 2/3: pose 2.] ;
  57:  MESSAGE[NO load. Measure M1.] ;
  58:  PAUSE ;
  59:  MESSAGE[Experiment 2/3: hang 10] ;
  60:  MESSAGE[kg, Fx 0 Fy 0 Fz -98.07] ;
  61:  MESSAGE[N, Tx 1.5 Ty 0 Tz -2] ;
  62:  MESSAGE[N.m.] ;
  63:  PAUSE ;
  64:  WAIT   2.00(sec) ;
  65:  MESSAGE[Experiment 2/3: pose 2.] ;
  66:  MESSAGE[LOADED. Measure M1.] ;
  67:  PAUSE ;
  68:  MESSAGE[Experiment 2/3: take the] ;
  69:  MESSAGE[load off. The robot] ;
  70:  MESSAGE[moves next.] ;
  71:  PAUSE ;
  72:  !to AP2 ;
  73:J P[4] 25% FINE    ;
  74:  !to P2 ;
  75:J P[5] 25% FINE    ;
  76:  WAIT   2.00(sec) ;
  77:  MESSAGE[Experiment 3/3: pose 2.] ;
  78:  MESSAGE[NO load. Measure M1.] ;
  79:  PAUSE ;
  80:  MESSAGE[Experiment 3/3: hang 10] ;
  81:  MESSAGE[kg, Fx 0 Fy 0 Fz -98.07] ;
  82:  MESSAGE[N, Tx 1.5 Ty 0 Tz -2] ;
  83:  MESSAGE[N.m.] ;
  84:  PAUSE ;
  85:  WAIT   2.00(sec) ;
  86:  MESSAGE[Experiment 3/3: pose 2.] ;
  87:  MESSAGE[LOADED. Measure M1.] ;
  88:  PAUSE ;
  89:  MESSAGE[Experiment 3/3: take the] ;
  90:  MESSAGE[load off. The robot] ;
  91:  MESSAGE[moves next.] ;
  92:  PAUSE ;
  93:  !to H0 ;
  94:J P[1] 25% FINE    ;
/POS
P[1]{
   GP1:
	UF : 0, UT : 1,	
	J1=    0.0000 deg,	J2=    0.0000 deg,	J3=    0.0000 deg,
	J4=    0.0000 deg,	J5=    0.0000 deg,	J6=    0.0000 deg,
	E1=    0.0000  mm
};
P[2]{
   GP1:
	UF : 0, UT : 1,	
	J1=    5.2296 deg,	J2=  -11.9592 deg,	J3=   16.6887 deg,
	J4=  -23.4183 deg,	J5=   28.1479 deg,	J6=  -34.8775 deg,
	E1= 1233.5679  mm
};
P[3]{
   GP1:
	UF : 0, UT : 1,	
	J1=    5.7296 deg,	J2=  -11.4592 deg,	J3=   17.1887 deg,
	J4=  -22.9183 deg,	J5=   28.6479 deg,	J6=  -34.3775 deg,
	E1= 1234.5679  mm
};
P[4]{
   GP1:
	UF : 0, UT : 1,	
	J1=   62.5254 deg,	J2=   68.2549 deg,	J3=  -74.9845 deg,
	J4=   79.7141 deg,	J5=  -86.4437 deg,	J6=  177.1169 deg,
	E1=  499.0000  mm
};
P[5]{
   GP1:
	UF : 0, UT : 1,	
	J1=   63.0254 deg,	J2=   68.7549 deg,	J3=  -74.4845 deg,
	J4=   80.2141 deg,	J5=  -85.9437 deg,	J6=  177.6169 deg,
	E1=  500.0000  mm
};
/END
